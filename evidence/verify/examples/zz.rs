//! Scratch.
use verify::whole::*;
fn main() {
    let list = scenes().unwrap();
    for (n, exact) in &list {
        let [short, front] = lengths(&n.scene.parameters);
        println!("# {} short {short:.4} front {front:.5} {exact:?}", n.name);
        for d in [1usize, 3, 5, 7] {
            for k in [4.0, 6.0, 8.0, 12.0, 16.0, 20.0, 24.0, 32.0, 48.0, 64.0f64] {
                if (d > 3 && k > 48.0) || (d == 1 && k < 12.0) {
                    continue;
                }
                let e = errors(&n.scene, exact, d, short / k * 1.0000001).unwrap();
                if let Some(e) = e {
                    let s: Vec<_> = e.iter().map(|e| format!("{:+.2e}", e)).collect();
                    let p = meshed(&n.scene, d, short / k * 1.0000001).parameters;
                    println!(
                        "{} {d} {k} {} {} {:.3} {}",
                        n.name.replace(' ', "_"),
                        p.piston.elements,
                        p.bit.elements,
                        short / k / front,
                        s.join(" ")
                    );
                }
            }
        }
    }
}
