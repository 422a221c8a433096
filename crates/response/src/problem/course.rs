//! How far the signals of channels have been integrated, in doubles.

use super::angle::reduced_angle;
use super::channel::Channel;
use super::grid::TimeGrid;
use super::timeline::Timeline;

/// The most integrals of a signal: an acceleration's two, and those of the highest power of time.
pub(crate) const MOST_INTEGRALS: usize = 8;

/// Of u and its derivatives, as many as are kept: up to the last that a power of time has.
pub(super) const ORDERS: usize = MOST_INTEGRALS + 1;

/// By piece and channel: u, u′, … at the piece's start, of those that the channel integrates.
#[derive(Clone, Debug)]
pub(super) struct Courses {
    starts: Vec<[f64; MOST_INTEGRALS]>,
    /// How many coordinates there are before the first channel.
    coordinates: usize,
    channels: usize,
}

impl Courses {
    pub(super) fn of(
        timeline: &Timeline,
        channels: &[Channel],
        coordinates: usize,
        grid: &TimeGrid,
    ) -> Courses {
        let mut courses = Courses {
            starts: vec![[0.0; MOST_INTEGRALS]; channels.len()],
            coordinates,
            channels: channels.len(),
        };
        if channels.iter().all(|channel| channel.integrals == 0) {
            return courses;
        }
        for (piece, pair) in timeline.pieces().windows(2).enumerate() {
            let time = pair[1].start.since(&pair[0].start, grid);
            let next: Vec<[f64; MOST_INTEGRALS]> = (0..channels.len())
                .map(|at| courses.at(timeline, channels, at, piece, time))
                .collect();
            courses.starts.extend(next);
        }
        courses
    }

    /// u, u′, … of a channel so many seconds after the start of a piece, as far as it integrates them.
    fn at(
        &self,
        timeline: &Timeline,
        channels: &[Channel],
        channel: usize,
        piece: usize,
        time: f64,
    ) -> [f64; MOST_INTEGRALS] {
        let integrals = channels[channel].integrals;
        if integrals == 0 {
            return [0.0; MOST_INTEGRALS];
        }
        let own = self.coordinates + channel;
        // The integrals of the signal over this time: once, twice, ….
        let mut own_part = [0.0; MOST_INTEGRALS];
        let begun = &timeline.pieces()[piece];
        for straight in begun.straight().iter().filter(|one| one.coordinate == own) {
            let mut power = 1.0;
            for (times, sum) in (1..).map(f64::from).zip(&mut own_part[..integrals]) {
                power *= time / times;
                *sum += power * (straight.value + straight.slope * time / (times + 1.0));
            }
        }
        let start = begun.start.time;
        timeline.waves(piece, start, |on, [sine, cosine], angle, rate| {
            if on != own {
                return;
            }
            // Nothing that swings is integrated more than twice.
            let [once, twice, ..] = &mut own_part;
            let (s, c) = angle.sin_cos();
            if rate == 0.0 {
                let value = sine * s + cosine * c;
                *once += value * time;
                *twice += value * time * time / 2.0;
                return;
            }
            // Integrals of sin(angle + rate·τ) and cos(angle + rate·τ), by the half angle.
            let turned = |from: f64| reduced_angle(0.5 * rate, time.into(), from);
            let (half, way) = (turned(0.0).sin(), turned(angle));
            let by_sine = 2.0 / rate * half * way.sin();
            let by_cosine = 2.0 / rate * half * way.cos();
            *once += sine * by_sine + cosine * by_cosine;
            *twice += sine * (c * time - by_cosine) / rate + cosine * (by_sine - s * time) / rate;
        });
        let before = &self.starts[piece * self.channels + channel][..integrals];
        let mut now = [0.0; MOST_INTEGRALS];
        for (k, now) in now.iter_mut().enumerate().take(integrals) {
            let mut power = 1.0;
            for (times, start) in (1..).map(f64::from).zip(&before[k..]) {
                *now += power * start;
                power *= time / times;
            }
            *now += own_part[integrals - k - 1];
        }
        now
    }

    /// Calls `push` with each channel's u and its derivatives at `t` s, by the law of the given piece: of what swings, four more than
    /// are integrated.
    pub(super) fn each(
        &self,
        timeline: &Timeline,
        channels: &[Channel],
        piece: usize,
        t: f64,
        mut push: impl FnMut(usize, [f64; ORDERS]),
    ) {
        let mut all = vec![[0.0; ORDERS]; channels.len()];
        timeline.signals(piece, t, |on, derivatives| {
            if let Some(channel) = on.checked_sub(self.coordinates) {
                let all = all[channel].iter_mut().skip(channels[channel].integrals);
                all.zip(derivatives).for_each(|(sum, part)| *sum += part);
            }
        });
        let time = t - timeline.pieces()[piece].start();
        for (channel, mut derivatives) in all.into_iter().enumerate() {
            let integrated = self.at(timeline, channels, channel, piece, time);
            for (into, value) in derivatives
                .iter_mut()
                .zip(integrated)
                .take(channels[channel].integrals)
            {
                *into = value;
            }
            push(channel, derivatives);
        }
    }
}
