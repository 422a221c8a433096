//! Angles of sinusoids at an instant.

use std::f64::consts::TAU;

use eigentone_digits::DoubleDouble;

/// Ωt + φ less whole turns, to units of rounding of a turn, however large Ωt and φ are.
pub(crate) fn reduced_angle(frequency: f64, time: DoubleDouble, phase: f64) -> f64 {
    /// Up to here whole turns times 2π in double-double leave what a double shows of the rest.
    const SMALL: f64 = (1u64 << 45) as f64;
    let [high, low] = [time.high(), time.low()].map(|time| DoubleDouble::product(frequency, time));
    let mut rest = DoubleDouble::ZERO;
    // Their sum is exact; what is too large for 2π in double-double is reduced by itself, with as many digits as it takes.
    for part in [high.high(), low.high(), high.low(), low.low(), phase] {
        rest += DoubleDouble::from(match part.abs() <= SMALL {
            true => part,
            false => {
                let (sine, cosine) = part.sin_cos();
                sine.atan2(cosine)
            }
        });
    }
    let turns = (rest.to_f64() / TAU).round();
    (rest - DoubleDouble::TAU * turns).to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ω, t, φ and sin(Ωt + φ) to 17 digits, from 2π to 2600 bits.
    const SINES: [[f64; 4]; 9] = [
        [2.5, 0.4, 7.0, 0.98935824662338177],
        [0.0, 1.0, 1e4, -0.30561438888825214],
        [0.0, 1.0, 1e9, 0.54584344944869956],
        [0.0, 1.0, 1e17, -0.4645301048353727],
        [0.0, 1.0, -1e100, 0.38063773100502867],
        [0.0, 1.0, 1.7e308, -0.59525608486320767],
        [1e9, 9.7, 0.3, 0.24339842982843386],
        [1e17, 3.3, 1e17, -0.32961993133924255],
        [1e200, 1e100, -2.5, -0.9470282761667542],
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
