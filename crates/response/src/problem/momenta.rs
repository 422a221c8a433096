//! What changes velocities at once: impulses, and jumps of supports that dampers and carried masses pass on.

use eigentone_digits::{Magnitude, Real};

use super::channel::Channel;
use super::straight_load::{Known, sum};
use super::timeline::Timeline;

/// The momenta that n coordinates take at the start of a piece: index and momentum in N·s, which add up. `jump` gives by how
/// much the straight part of a channel's signal, and its slope, jump there; `wave` the cosine and sine of an angle.
pub(crate) fn momenta<T: Real>(
    timeline: &Timeline,
    channels: &[Channel],
    n: usize,
    piece: usize,
    jump: impl Fn(usize) -> [Known<T>; 2],
    wave: impl Fn(f64) -> (T, T, Magnitude),
) -> Vec<(usize, Known<T>)> {
    let begun = &timeline.pieces()[piece];
    let mut momenta = Vec::new();
    for &(on, magnitude) in begun.impulses() {
        let momentum = (T::from(magnitude), Magnitude::ZERO);
        match on.checked_sub(n) {
            None => momenta.push((on, momentum)),
            Some(channel) => {
                let shares = channels[channel].directions[0].iter();
                momenta.extend(shares.map(|&(row, share)| (row, times(momentum, share))));
            }
        }
    }
    for (at, channel) in (n..).zip(channels) {
        if !channel.passes_on(0) && !channel.passes_on(1) {
            continue;
        }
        let [mut value, mut slope] = jump(at);
        for pulse in timeline
            .pulses()
            .iter()
            .filter(|pulse| pulse.coordinate == at)
        {
            let (rate, ends) = (pulse.rate.value::<T>(), pulse.ends());
            for (here, [v, s], sign) in [
                (pulse.bounds(begun)[0], ends[0], 1.0),
                (pulse.bounds(begun)[1], ends[1], -1.0),
            ] {
                if here {
                    value = sum(value, (T::from(sign * v), Magnitude::ZERO));
                    slope = sum(slope, times(rate, sign * s));
                }
            }
        }
        let harmonics = timeline.harmonics().iter();
        for (_, harmonic) in harmonics.filter(|(on, _)| piece == 0 && *on == at) {
            let (cosine, sine, error) = wave(harmonic.phase);
            value = sum(value, times((sine, error), harmonic.amplitude));
            let growth = times((cosine, error), harmonic.amplitude);
            slope = sum(slope, times(growth, harmonic.frequency));
        }
        for (order, jump) in [value, slope].into_iter().enumerate() {
            let Some(direction) = channel.directions.get(channel.integrals + order + 1) else {
                continue;
            };
            if !(jump.0.is_zero() && jump.1.is_zero()) {
                let each = direction.iter();
                momenta.extend(each.map(|&(row, factor)| (row, times(jump, factor))));
            }
        }
    }
    momenta
}

/// A known number times a double.
fn times<T: Real>((value, error): Known<T>, factor: f64) -> Known<T> {
    let product = value * T::from(factor);
    let exact = factor == 0.0 || value.is_zero() || factor.abs() == 1.0;
    let rounding = match exact {
        true => Magnitude::ZERO,
        false => product.upper() * T::unit() + T::floor(),
    };
    (product, error * Magnitude::from(factor.abs()) + rounding)
}
