use hammer::{Fidelity, InputValues, Machine, Parameters, Source};
fn args() -> Vec<f64> { std::env::args().skip(1).map(|s| s.parse().unwrap()).collect() }
fn main() {
    let a = args();
    // sd sr cyl vd0/Ad vr0/Ar  ds de rs re height ratio(ex/sup) leak hole_k
    let [sd, sr, cyl, ld, lr, ds, de, rs, re, height, ratio] = a[..11] else { panic!() };
    let atm = 101_325.0;
    for (od, mass, air, power, hole) in [(85.0, 5.5, [4.5, 8.3, 11.1], 20.9, 0.09), (105.0, 9.1, [6.7, 12.5, 16.9], 29.1, 0.115), (127.0, 19.0, [7.1, 14.9, 21.4], 31.7, 0.14), (150.0, 23.9, [8.8, 17.8, 24.0], 34.5, 0.165)] {
        let bore = std::f64::consts::FRAC_PI_4 * (0.866e-3f64 * od).powi(2);
        let mut p = Parameters { fidelity: Fidelity::Rigid, ..Parameters::default() };
        p.drive.source = Source::Air;
        (p.drive.area_drive, p.drive.area_return) = (sd * bore, sr * bore);
        p.piston.segments = 1; p.piston.segment[0].area = 0.7 * bore; p.piston.segment[0].length = mass / (7850.0 * 0.7 * bore);
        p.bit.segments = 1; p.bit.segment[0] = p.piston.segment[0];
        let share = (hole / 0.09f64).powi(2);
        p.rock.stiffness *= share; p.rock.viscosity *= share; p.rock.energy_barrier *= share; p.hole.diameter = hole;
        p.air.cylinder = cyl; p.air.drive.dead_volume = ld * sd * bore; p.air.returning.dead_volume = lr * sr * bore;
        p.air.drive.supply = ds; p.air.drive.exhaust = de; p.air.returning.supply = rs; p.air.returning.exhaust = re; p.air.port_height = height;
        p.air.error = 1e-5;
        p.contact.initial_gap = 0.5 * cyl;
        let run = |supply: f64, gauge: f64| {
            let mut p = p;
            p.air.supply_area = supply; p.air.exhaust_area = ratio * supply;
            let inputs = InputValues { supply_pressure: gauge * 1e5 + atm, feed_force: 8e3 * share, ..InputValues::default() };
            let mut m = Machine::new(&p, &inputs, 0.0).ok()?;
            m.advance(0.35).ok()?;
            let mut low: f64 = 0.0;
            let b = *m.blow()?;
            for i in 1..60 { m.advance(0.35 + i as f64 * 5e-4).ok()?; low = low.min(m.kinematics().relative_position); }
            Some((b.air_flow * 60.0, b.speed, b.energy, 1.0 / b.period, low))
        };
        let (mut lo, mut hi) = (1e-6f64, 3e-3f64);
        for _ in 0..14 {
            let mid = (lo * hi).sqrt();
            match run(mid, 10.34) { Some((q, ..)) if q > air[0] => hi = mid, Some(_) => lo = mid, None => { hi = mid; } }
        }
        let supply = (lo * hi).sqrt();
        print!("OD {od} supply {:.0} mm2 bore {:.0} | ", supply * 1e6, bore * 1e6);
        for (k, g) in [10.34, 17.24, 24.13].into_iter().enumerate() {
            match run(supply, g) { Some((q, v, e, f, low)) => print!("{g}: air {q:.1} ({:+.0}%) v {v:.1} E {e:.0} f {f:.1} P {:.1} low {low:.3} | ", 100.0 * (q / air[k] - 1.0), e * f / 1e3), None => print!("{g}: - | ") }
        }
        println!("published {power}");
    }
}
