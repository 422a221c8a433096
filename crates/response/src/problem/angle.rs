//! Angles of sinusoids at an instant.

use std::f64::consts::TAU;

use eigentone_digits::DoubleDouble;

/// Up to here whole turns times 2π in double-double leave what a double shows of the rest.
const SMALL: f64 = (1u64 << 45) as f64;

/// Ωt + φ less whole turns, to units of rounding of a turn, however large Ωt and φ are.
pub(crate) fn reduced_angle(frequency: f64, time: DoubleDouble, phase: f64) -> f64 {
    let angle = time * frequency;
    let rest = match angle.high().abs() <= SMALL && phase.abs() <= SMALL {
        true => angle + DoubleDouble::from(phase),
        false => reduced_parts(frequency, time, phase),
    };
    let turns = (rest.to_f64() / TAU).round_ties_even();
    (rest - DoubleDouble::TAU * turns).to_f64()
}

/// The same angle from parts whose sum is exact: what is too large for 2π in double-double is reduced by itself, with as
/// many digits as it takes.
#[cold]
fn reduced_parts(frequency: f64, time: DoubleDouble, phase: f64) -> DoubleDouble {
    let [high, low] = [time.high(), time.low()].map(|time| DoubleDouble::product(frequency, time));
    let parts = [high.high(), low.high(), high.low(), low.low(), phase];
    let mut sum = DoubleDouble::ZERO;
    for part in parts {
        sum += DoubleDouble::from(match part.abs() <= SMALL {
            true => part,
            false => {
                let (sine, cosine) = part.sin_cos();
                sine.atan2(cosine)
            }
        });
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ω, t, φ and sin(Ωt + φ) to 17 digits, from 2π to 2600 bits.
    const SINES: [[f64; 4]; 9] = [
        [2.5, 0.4, 7.0, 0.989_358_246_623_381_8],
        [0.0, 1.0, 1e4, -0.305_614_388_888_252_1],
        [0.0, 1.0, 1e9, 0.545_843_449_448_699_6],
        [0.0, 1.0, 1e17, -0.464_530_104_835_372_7],
        [0.0, 1.0, -1e100, 0.380_637_731_005_028_7],
        [0.0, 1.0, 1.7e308, -0.595_256_084_863_207_7],
        [1e9, 9.7, 0.3, 0.243_398_429_828_433_86],
        [1e17, 3.3, 1e17, -0.329_619_931_339_242_55],
        [1e200, 1e100, -2.5, -0.947_028_276_166_754_2],
    ];

    #[test]
    fn large_angles_lose_no_digits() {
        for [frequency, time, phase, sine] in SINES {
            let angle = reduced_angle(frequency, time.into(), phase);
            assert!(
                angle.abs() < 3.2,
                "{frequency:e} {time:e} {phase:e}: {angle}"
            );
            let off = (angle.sin() - sine).abs();
            assert!(off < 1.5e-15, "{frequency:e} {time:e} {phase:e}: {off:e}");
        }
    }
}
