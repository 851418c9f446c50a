//! Counter-based numbers: the twin of `kernels/shared/random.glsl` on the host.

/// A 32-bit finaliser with low bias (Wellons 2018).
pub fn mix_bits(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A seed made of a seed and a number.
pub fn combine(seed: u32, value: u32) -> u32 {
    mix_bits(seed ^ value.wrapping_mul(0x9e37_79b9).wrapping_add(0x7f4a_7c15))
}

fn owen_scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

fn to_unit(x: u32) -> f32 {
    (x >> 8) as f32 / 16_777_216.0
}

fn sobol_second(index: u32) -> u32 {
    let mut direction = 0x8000_0000u32;
    (0..32).fold(0, |result, bit| {
        let result = if index >> bit & 1 != 0 { result ^ direction } else { result };
        direction ^= direction >> 1;
        result
    })
}

/// Point `index` of a scrambled (0,2)-sequence in the unit square; seeds decorrelate sequences.
pub fn sample_2d(index: u32, seed: u32) -> [f32; 2] {
    let shuffled = owen_scramble(index, combine(seed, 1));
    [
        to_unit(owen_scramble(shuffled.reverse_bits(), combine(seed, 2))),
        to_unit(owen_scramble(sobol_second(shuffled), combine(seed, 3))),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_points_are_stratified_in_every_elementary_interval() {
        for seed in 0..20 {
            for shape in 0..=8u32 {
                let mut hit = vec![false; 256];
                for index in 0..256 {
                    let [x, y] = sample_2d(index, seed);
                    let cell = ((x * (1u32 << shape) as f32) as usize) << (8 - shape)
                        | (y * (1u32 << (8 - shape)) as f32) as usize;
                    assert!(!std::mem::replace(&mut hit[cell], true), "seed {seed} shape {shape} index {index}");
                }
            }
        }
    }
}
