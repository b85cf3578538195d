use hammer::*;
fn main() {
    let v: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string("peers/data/reference_20.json").unwrap())
            .unwrap();
    let mut m = Machine::new(&Parameters::default(), &InputValues::default(), 0.0).unwrap();
    m.keep_journal(true);
    m.advance(0.1).unwrap();
    let j = m.take_journal();
    for (i, (r, e)) in j.iter().zip(v["events"].as_array().unwrap()).enumerate() {
        let t = e["time"].as_f64().unwrap();
        println!(
            "{i} {:.9} {} {} {} err {:e}",
            t,
            r.event,
            e["event"],
            e["mode"]["rock"],
            (r.time - t) + (r.time_rest - e["time_rest"].as_f64().unwrap())
        );
    }
    println!("{} {}", j.len(), v["events"].as_array().unwrap().len());
}
