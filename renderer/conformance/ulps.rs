//! Distances between floats.

/// How far `found` is from `exact`, in steps between 32-bit floats of that size. What is no number is infinitely far.
pub fn ulps(found: f32, exact: f64) -> f64 {
    let size = (exact.abs() as f32).max(f32::MIN_POSITIVE);
    let step = f64::from(f32::from_bits(size.to_bits() & 0x7f80_0000)) * 2f64.powi(-23);
    let distance = (f64::from(found) - exact).abs() / step;
    if distance.is_nan() { f64::INFINITY } else { distance }
}

/// `exact` rounded to nearest, and towards zero.
pub fn roundings(exact: f64) -> [f32; 2] {
    let nearest = exact as f32;
    let beyond = f64::from(nearest).abs() > exact.abs();
    // The next number towards zero has the next smaller bits, on both sides of it.
    let towards_zero = if beyond { f32::from_bits(nearest.to_bits() - 1) } else { nearest };
    [nearest, towards_zero]
}

/// The value of a 16-bit float.
pub fn from_half(bits: u16) -> f32 {
    let sign = if bits & 0x8000 != 0 { -1.0 } else { 1.0 };
    let (exponent, mantissa) = (i32::from(bits >> 10 & 0x1f), f32::from(bits & 0x3ff));
    match exponent {
        0 => sign * mantissa * 2f32.powi(-24),
        31 if mantissa == 0.0 => sign * f32::INFINITY,
        31 => f32::NAN,
        _ => sign * (1.0 + mantissa / 1024.0) * 2f32.powi(exponent - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_an_ulp() {
        for x in [1.0f32, 1.5, -3.0e-20, 7.0e30] {
            let next = f32::from_bits(x.to_bits() + 1);
            assert_eq!(ulps(next, x.into()), 1.0);
            assert_eq!(ulps(x, x.into()), 0.0);
        }
        assert_eq!(ulps(f32::NAN, 1.0), f64::INFINITY);
    }

    #[test]
    fn sums_round_both_ways() {
        assert_eq!(roundings(1.0 + 2f64.powi(-24) * 1.5), [1.0 + f32::EPSILON, 1.0]);
        assert_eq!(roundings(-1.0 - 2f64.powi(-24) * 1.5), [-1.0 - f32::EPSILON, -1.0]);
    }

    #[test]
    fn halves_have_their_values() {
        assert_eq!([0x3c00, 0xc000, 0x7bff, 0x0001].map(from_half), [1.0, -2.0, 65504.0, 2f32.powi(-24)]);
        assert!(from_half(0x7c00).is_infinite() && from_half(0x7e00).is_nan());
    }
}
