//! `oracles::dd` beside `twofloat`: a tridiagonal solve, the reference's inner loop,
//! and a division, in time and in digits.
//!
//! `cargo run --release -p oracles --example dd_speed`

use oracles::dd::Dd;
use oracles::model::Tridiagonal;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::time::Instant;
use twofloat::TwoFloat;

const NODES: usize = 42;
const ROUNDS: u32 = 20_000;

/// `twofloat` behind the model's trait.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
struct Two(TwoFloat);

macro_rules! forward {
    ($($operator:ident $name:ident)*) => {$(
        impl $operator for Two {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self($operator::$name(self.0, other.0))
            }
        }
    )*};
}
forward!(Add add Sub sub Mul mul Div div);

impl Neg for Two {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl From<f64> for Two {
    fn from(x: f64) -> Self {
        Self(TwoFloat::from(x))
    }
}

impl oracles::model::Real for Two {
    fn to_f64(self) -> f64 {
        self.0.hi()
    }
}

/// Time of a solve, us. The factor keeps the dominant component, whose eigenvalue
/// is close to 1 / (0.7 - 0.3), of about the same size.
fn solve<T: oracles::model::Real>() -> f64 {
    let matrix =
        Tridiagonal { diagonal: vec![T::from(0.7); NODES], off: vec![T::from(0.15); NODES - 1] };
    let factor = matrix.factor();
    let mut x: Vec<T> = (0..NODES).map(|i| T::from(1.0 / (i + 1) as f64)).collect();
    let clock = Instant::now();
    for _ in 0..ROUNDS {
        factor.solve(&mut x);
        for x in &mut x {
            *x = *x * T::from(0.4);
        }
    }
    std::hint::black_box(&x);
    clock.elapsed().as_secs_f64() / f64::from(ROUNDS) * 1e6
}

/// Worst `|q b - a|` over some quotients `q = a / b`.
fn division<T: oracles::model::Real>() -> f64 {
    (1..50).fold(0.0, |max, i| {
        let (a, b) = (T::from(1.0), T::from(f64::from(i) * 0.1));
        max.max((a / b * b - a).to_f64().abs())
    })
}

fn main() {
    let (own_time, two_time) = (solve::<Dd>(), solve::<Two>());
    println!("{NODES} nodes: own {own_time:.2} us a solve, twofloat {two_time:.2} us");
    let (own, two) = (division::<Dd>(), division::<Two>());
    println!("residual of a quotient: own {own:.1e}, twofloat {two:.1e}");
}
