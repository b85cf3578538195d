//! Air that a hammer takes, among the means of its blows, and the ports that are fitted to it.

use hammer::datasheet::AirBlow;
use hammer::means::{Wanted, steady};
use hammer::presets::AirHammer;

fn hammer() -> AirHammer {
    AirHammer {
        outer: 0.105,
        piston: 9.1,
        casing: 27.0,
        supply: 2e-4,
        hole: 0.115,
        feed: 17e3,
        stroke: 1.0,
    }
}

/// Two ways to one number: what the supply has lost over whole blows, and the mean of a long run.
#[test]
fn air_is_among_the_means() -> Result<(), Box<dyn std::error::Error>> {
    let scene = hammer().at(20e5);
    let mean = steady(&scene, &Wanted::default(), &mut |_, _| true)?.mean;
    let blow = AirBlow::settled(&scene)?;
    // The blows repeat to 1e-3 after a dozen.
    assert!((mean.get("air_flow") / blow.flow - 1.0).abs() < 2e-3, "{mean:?} {blow:?}");
    assert!((mean.get("blow_energy") / blow.energy - 1.0).abs() < 2e-3, "{mean:?} {blow:?}");
    Ok(())
}

/// What is fitted is met; a hammer that cannot take so much says so.
#[test]
fn ports_are_fitted_to_the_air() -> Result<(), Box<dyn std::error::Error>> {
    let wanted = 8.0 / 60.0;
    let (fitted, blow) =
        hammer().fitted(|hammer: &AirHammer| hammer.at(12e5), wanted, |blow| blow.flow)?;
    assert!((blow.flow / wanted - 1.0).abs() < 2e-3, "{blow:?}");
    // Another simulation of what was found has it too.
    let again = AirBlow::settled(&fitted.at(12e5))?;
    assert_eq!(again, blow);
    Ok(())
}
