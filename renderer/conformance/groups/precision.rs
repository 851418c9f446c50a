//! Arithmetic against f64: what Vulkan bounds, and what watertight tracing needs beyond that.

use std::f64::consts::PI;

use super::{Bench, Case, CaseError};
use crate::conformance::case::Worst;
use crate::conformance::faults::{Fault, injected};
use crate::conformance::rays::Random;
use crate::conformance::ulps::{roundings, ulps};
use crate::gpu::{Bindings, Buffer};

const fn case(
    name: &'static str,
    about: &'static str,
    catches: &'static [Fault],
    run: fn(&mut Bench<'_>) -> Result<(), CaseError>,
) -> Case {
    Case { group: "precision", name, about, needs: &[], minds: &[], catches, run }
}

pub(super) const CASES: &[Case] = &[
    case(
        "arithmetic",
        "sums, products, division and roots within the bounds of the Vulkan specification",
        &[],
        arithmetic,
    ),
    case("functions", "exp2, log2, sin, cos and floor within the bounds of the Vulkan specification", &[], functions),
    case(
        "no_contraction",
        "`precise` a * b + c and a * b - c * d are not fused, as watertight tracing needs",
        &[],
        contraction,
    ),
    case("comparisons", "comparisons of zeros, infinities and NaN answer as IEEE 754 says", &[], comparisons),
    case(
        "denormals",
        "moving numbers keeps the smallest; whether arithmetic does is reported",
        &[Fault::Denormals],
        denormals,
    ),
];

/// Numbers a kernel takes and gives, as in `arithmetic.comp.glsl`.
const RESULTS: usize = 16;
const OPERANDS: usize = 1 << 16;

/// x, y, z, w. In every second quad z cancels x * y, in the others z * w does.
fn operands() -> Vec<[f32; 4]> {
    let mut random = Random(5);
    let mut number = |low: i32, high: i32| {
        let exponent = low + random.below((high - low) as usize) as i32;
        let sign = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
        sign * (1.0 + random.unit()) * 2f32.powi(exponent)
    };
    let quad = |i: usize| {
        let (x, y) = if i % 4 < 2 { (number(-1, 1), number(-1, 1)) } else { (number(-20, 20), number(-20, 20)) };
        let z = if i.is_multiple_of(2) { -x * y } else { number(-1, 1) };
        let w = if i % 4 == 1 { x * y / z } else { number(-3, 2) };
        [x, y, z, w]
    };
    (0..OPERANDS).map(quad).collect()
}

/// Quads of operands, and what the kernel made of each.
type Answers = (Vec<[f32; 4]>, Vec<[f32; RESULTS]>);

fn results(bench: &Bench<'_>) -> Result<Answers, CaseError> {
    let operands = operands();
    let input = Buffer::from_slice(bench.device, "operands", &operands)?;
    let output = bench.words("results", (OPERANDS * RESULTS) as u32)?;
    let bindings = Bindings::new().buffer("Operands", &input).buffer("Floats", &output);
    bench.run("arithmetic", &bindings, OPERANDS as u32, [0; 3])?;
    Ok((operands, output.read(OPERANDS)?))
}

/// What of a quad a function takes, and its value in f64; `None` outside of the range that is bounded.
type Oracle = fn([f64; 4]) -> Option<f64>;

/// The worst distance of a result from its oracle, in `measure` of result and oracle.
fn worst(
    operands: &[[f32; 4]],
    results: &[[f32; RESULTS]],
    index: usize,
    oracle: Oracle,
    measure: impl Fn(f32, f64, [f64; 4]) -> f64,
) -> Worst {
    let mut worst = Worst::default();
    for (quad, found) in operands.iter().zip(results) {
        let exact = quad.map(f64::from);
        if let Some(expected) = oracle(exact) {
            let found = found[index];
            worst.see(measure(found, expected, exact), || format!("of {quad:?}: {found:e}, not {expected:e}"));
        }
    }
    worst
}

fn arithmetic(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let (operands, results) = results(bench)?;
    // Correctly rounded, whichever way: less than one unit in the last place.
    let table: [(&str, usize, Oracle, f64); 8] = [
        ("x + y", 0, |q| Some(q[0] + q[1]), 1.0),
        ("x - y", 1, |q| Some(q[0] - q[1]), 1.0),
        ("x * y", 2, |q| Some(q[0] * q[1]), 1.0),
        ("x / y", 3, |q| Some(q[0] / q[1]), 2.5),
        ("1 / x", 15, |q| Some(1.0 / q[0]), 2.5),
        // Inherited from 1 / inversesqrt(x): two units there, and two and a half of the division.
        ("sqrt(|x|)", 4, |q| Some(q[0].abs().sqrt()), 4.5),
        ("inversesqrt(|x|)", 5, |q| Some(1.0 / q[0].abs().sqrt()), 2.0),
        ("floor(w)", 13, |q| Some(q[3].floor()), 0.0),
    ];
    for (what, index, oracle, bound) in table {
        bench.at_most(what, worst(&operands, &results, index, oracle, |a, b, _| ulps(a, b)), bound, "ulp");
    }
    Ok(())
}

fn functions(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let (operands, results) = results(bench)?;
    let over = |a: f32, b: f64, q: [f64; 4]| ulps(a, b) / (3.0 + 2.0 * q[3].abs());
    bench.at_most("exp2(w)", worst(&operands, &results, 9, |q| Some(q[3].exp2()), over), 1.0, "of 3 + 2 |w| ulp");
    let far: Oracle = |q| (!(0.5..=2.0).contains(&q[0].abs())).then(|| q[0].abs().log2());
    bench.at_most(
        "log2(|x|) outside of [0.5, 2]",
        worst(&operands, &results, 10, far, |a, b, _| ulps(a, b)),
        3.0,
        "ulp",
    );
    let absolute = |a: f32, b: f64, _: [f64; 4]| (f64::from(a) - b).abs();
    let near: Oracle = |q| (0.5..=2.0).contains(&q[0].abs()).then(|| q[0].abs().log2());
    bench.at_most("log2(|x|) within [0.5, 2]", worst(&operands, &results, 10, near, absolute), 2f64.powi(-21), "");
    let sine: Oracle = |q| (q[3].abs() <= PI).then(|| q[3].sin());
    let cosine: Oracle = |q| (q[3].abs() <= PI).then(|| q[3].cos());
    bench.at_most("sin(w) within [-pi, pi]", worst(&operands, &results, 11, sine, absolute), 2f64.powi(-11), "");
    bench.at_most("cos(w) within [-pi, pi]", worst(&operands, &results, 12, cosine, absolute), 2f64.powi(-11), "");
    Ok(())
}

/// All values that a * b + c may have when both roundings are made, each to nearest or towards zero.
fn unfused(products: impl IntoIterator<Item = f64>, other: impl Fn(f64) -> Vec<f64>) -> Vec<f32> {
    let rounded = products.into_iter().flat_map(|product| roundings(product).map(f64::from));
    rounded.flat_map(|product| other(product).into_iter().flat_map(roundings)).collect()
}

fn contraction(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let (operands, results) = results(bench)?;
    let (mut sums, mut areas) = (Worst::default(), Worst::default());
    let (mut wrong, mut plain, mut fma, mut telling) = ([0u32; 2], 0u32, 0u32, 0u32);
    for (quad, found) in operands.iter().zip(&results) {
        let [x, y, z, w] = quad.map(f64::from);
        let sum = unfused([x * y], |product| vec![product + z]);
        if !sum.contains(&found[6]) {
            wrong[0] += 1;
            sums.see(wrong[0].into(), || format!("first of {quad:?}: {:e}, not {:e}", found[6], sum[0]));
        }
        let area = unfused([x * y], |product| roundings(z * w).map(|other| product - f64::from(other)).to_vec());
        if !area.contains(&found[7]) {
            wrong[1] += 1;
            areas.see(wrong[1].into(), || format!("first of {quad:?}: {:e}, not {:e}", found[7], area[0]));
        }
        // Where one rounding gives another number than two.
        let fused = x.mul_add(y, z) as f32;
        if !sum.contains(&fused) {
            telling += 1;
            plain += u32::from(found[8] == fused);
            fma += u32::from(found[14] == fused);
        }
    }
    sums.measured = wrong[0].into();
    areas.measured = wrong[1].into();
    bench.note("plain a * b + c", format!("fused in {plain} of {telling}"));
    bench.note("fma(a, b, c)", format!("fused in {fma} of {telling}"));
    bench.at_most("precise a * b + c that is fused or wrong", sums, 0.0, &format!("of {OPERANDS}"));
    bench.at_most("precise a * b - c * d that is fused or wrong", areas, 0.0, &format!("of {OPERANDS}"));
    Ok(())
}

/// What a comparison of two numbers should say.
type Answer = fn(f32, f32) -> bool;

fn comparisons(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::MIN_POSITIVE,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        -f32::NAN,
    ];
    let pairs: Vec<[f32; 4]> =
        special.iter().flat_map(|&x| special.iter().map(move |&y| [x, y, f32::INFINITY, 0.0])).collect();
    let input = Buffer::from_slice(bench.device, "operands", &pairs)?;
    let output = bench.words("said", pairs.len() as u32)?;
    let bindings = Bindings::new().buffer("Operands", &input).buffer("Gathered", &output);
    bench.run("compare", &bindings, pairs.len() as u32, [0; 3])?;
    let said: Vec<u32> = output.read(pairs.len())?;
    let questions: [(&str, Answer); 10] = [
        ("x < y", |x, y| x < y),
        ("x <= y", |x, y| x <= y),
        ("x > y", |x, y| x > y),
        ("x >= y", |x, y| x >= y),
        ("x == y", |x, y| x == y),
        ("x != y", |x, y| x != y),
        ("!(x < y)", |x, y| x.partial_cmp(&y) != Some(std::cmp::Ordering::Less)),
        ("!(x >= y)", |x, y| {
            !matches!(x.partial_cmp(&y), Some(std::cmp::Ordering::Greater | std::cmp::Ordering::Equal))
        }),
        ("x > y && x < infinity", |x, y| x > y && x < f32::INFINITY),
        ("exponent of x is full", |x, _| !x.is_finite()),
    ];
    for (bit, (what, answer)) in questions.into_iter().enumerate() {
        let mut worst = Worst::default();
        let mut wrong = 0;
        for ([x, y, ..], said) in pairs.iter().zip(&said) {
            let found = said >> bit & 1 == 1;
            if found != answer(*x, *y) {
                wrong += 1;
                worst.see(1.0, || format!("first of x = {x}, y = {y}: {found}"));
            }
        }
        worst.measured = wrong.into();
        bench.at_most(what, worst, 0.0, &format!("wrong of {}", pairs.len()));
    }
    Ok(())
}

fn denormals(bench: &mut Bench<'_>) -> Result<(), CaseError> {
    const COUNT: u32 = 256;
    let small = |i: u32| f32::from_bits((i * 32_771 + 1) & 0x007f_ffff | (i & 1) << 31);
    // In the product, half of a normal number that is no normal one.
    let quad = |i: u32| [small(i), small(i + COUNT), 0.5, 0.0];
    let mut quads: Vec<[f32; 4]> = (0..COUNT).map(quad).collect();
    if injected(Fault::Denormals) {
        let flush = |x: f32| if x.is_subnormal() { 0.0f32.copysign(x) } else { x };
        quads.iter_mut().for_each(|quad| *quad = quad.map(flush));
    }
    let input = Buffer::from_slice(bench.device, "operands", &quads)?;
    let output = bench.words("moved", 4 * COUNT)?;
    let bindings = Bindings::new().buffer("Operands", &input).buffer("Floats", &output);
    bench.run("denormals", &bindings, COUNT, [1, 0, 0])?;
    let found: Vec<[u32; 4]> = output.read(COUNT as usize)?;
    let expected = |i: u32| {
        let [x, y, ..] = quad(i).map(f32::to_bits);
        [x, if i % 2 == 1 { x } else { y }, x]
    };
    for (place, what) in ["loaded and stored", "chosen", "passed through a function"].into_iter().enumerate() {
        let moved: Vec<u32> = found.iter().map(|f| f[place]).collect();
        let kept: Vec<u32> = (0..COUNT).map(|i| expected(i)[place]).collect();
        bench.equal(&format!("numbers {what}, bit by bit"), &moved, &kept);
    }
    let products = found.iter().map(|f| f32::from_bits(f[3])).filter(|product| *product != 0.0).count();
    bench.note("products that are not flushed to zero", format!("{products} of {COUNT}"));
    Ok(())
}
