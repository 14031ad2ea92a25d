//! Randomness as a pure function of (seed, slot, generation, dimension): PCG hashes, 32-bit integers only.

/// The PCG-RXS-M-XS-32 permutation as a hash of one word (O'Neill 2014; Jarzynski, Olano 2020). Sums and products wrap.
pub fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// The random word that dimension `dimension` of the birth number `generation` in slot `slot` draws.
pub fn hash(seed: u32, slot: u32, generation: u32, dimension: u32) -> u32 {
    let word = pcg(slot.wrapping_add(pcg(seed)));
    pcg(dimension.wrapping_add(pcg(generation.wrapping_add(word))))
}

/// A random word as f32 in (0, 1): `((h >> 9) + 0.5) * 2^-23`, exact.
pub fn unit(h: u32) -> f32 {
    ((h >> 9) as f32 + 0.5) * (1.0 / 8_388_608.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same permutation in unbounded integers: remainders for wrapping, quotients for shifts, sums for exclusive or.
    fn pcg_by_arithmetic(v: u32) -> u32 {
        let modulus = 1_u128 << 32;
        let xor = |a: u128, b: u128| a + b - 2 * (0..32).map(|i| (((a >> i) % 2) * ((b >> i) % 2)) << i).sum::<u128>();
        let state = (u128::from(v) * 747_796_405 + 2_891_336_453) % modulus;
        let shift = state / (1 << 28) + 4;
        let word = xor(state / (1 << shift), state) * 277_803_737 % modulus;
        xor(word / (1 << 22), word) as u32
    }

    #[test]
    fn pcg_agrees_with_arithmetic_in_unbounded_integers() {
        for i in 0..2000_u32 {
            let v = i.wrapping_mul(0x9E37_79B9);
            assert_eq!(pcg(v), pcg_by_arithmetic(v), "pcg({v})");
        }
    }

    #[test]
    fn pcg_and_hash_have_their_known_values() {
        // Computed once with Python's integers.
        assert_eq!(pcg(0), 129_708_002);
        assert_eq!(pcg(1), 2_831_084_092);
        assert_eq!(pcg(12_345), 4_099_845_390);
        assert_eq!(pcg(u32::MAX), 3_861_530_882);
        assert_eq!(hash(7, 1, 2, 3), 1_882_059_318);
    }

    #[test]
    fn unit_is_exact_and_neither_zero_nor_one() {
        for h in [0, 0x1234_5678, 0x7FFF_FFFF, 0x8000_0000, u32::MAX] {
            assert_eq!(f64::from(unit(h)), (f64::from(h >> 9) + 0.5) / 8_388_608.0);
            assert!(unit(h) > 0.0 && unit(h) < 1.0);
        }
    }

    #[test]
    fn unit_is_uniform() {
        let mut bins = [0_u32; 16];
        for slot in 0..16_000 {
            bins[((unit(hash(3, slot, 0, 1)) * 16.0) as usize).min(15)] += 1;
        }
        // Binomial with mean 1000, deviation 31: five deviations.
        assert!(bins.iter().all(|n| (845..1155).contains(n)), "{bins:?}");
    }
}
