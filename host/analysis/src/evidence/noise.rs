//! The noise floor: what differs between runs of equal conditions, whatever its cause.
//!
//! A run's signal in one phase is reduced to its course: means over eight sections of equal
//! length, so that runs of different length compare. Their scatter from run to run, pooled
//! over conditions, `sum (x - mean)^2 / sum (n - 1)`, and the noise from sample to sample make
//! the floor. Without repetitions there is none: `None`, never zero.

pub use stickslip_data::signal::white_noise;

/// Sections of equal length into which a phase is cut.
pub const SECTIONS: usize = 8;
/// Fewer samples than this say nothing about a phase.
pub const FEWEST_SAMPLES: u32 = 3;

/// Mean course of one signal over one phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Samples in which it is known.
    pub samples: u32,
    /// Over the phase; NaN where nothing is known.
    pub mean: f64,
    /// Over each section; NaN where it holds no sample.
    pub sections: [f64; SECTIONS],
}

impl Course {
    /// Course of `values`; NaN: not measured.
    pub fn of(values: &[f64]) -> Self {
        let mut sums = [(0.0, 0u32); SECTIONS];
        for (i, x) in values.iter().enumerate().filter(|(_, x)| x.is_finite()) {
            let section = &mut sums[i * SECTIONS / values.len()];
            section.0 += x;
            section.1 += 1;
        }
        let mean = |(sum, count): (f64, u32)| if count > 0 { sum / f64::from(count) } else { f64::NAN };
        let all = sums.iter().fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        Self { samples: all.1, mean: mean(all), sections: sums.map(mean) }
    }

    /// Whether enough samples stand behind it.
    pub fn is_known(&self) -> bool {
        self.samples >= FEWEST_SAMPLES
    }

    /// Adds a constant to the signal.
    pub fn shift(&mut self, by: f64) {
        self.mean += by;
        self.sections.iter_mut().for_each(|s| *s += by);
    }
}

/// Sum of squares about the mean of what is finite, and its degrees of freedom.
pub fn about_mean(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let values = values.filter(|x| x.is_finite());
    let (n, sum) = values.clone().fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x));
    if n < 2.0 {
        return (0.0, 0.0);
    }
    (values.map(|x| (x - sum / n).powi(2)).sum(), n - 1.0)
}

/// Scatter of one signal in one phase, pooled over conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pool {
    squares: f64,
    degrees: f64,
    white_sq: f64,
    samples: f64,
    runs: f64,
}

impl Pool {
    /// Adds the runs of one condition: the course of each and its noise from sample to sample.
    pub fn add<'a>(&mut self, runs: impl Iterator<Item = (&'a Course, f64)> + Clone) {
        let runs = runs.filter(|(course, _)| course.is_known());
        for (course, white) in runs.clone() {
            self.samples += f64::from(course.samples);
            self.white_sq += white * white;
            self.runs += 1.0;
        }
        for section in 0..SECTIONS {
            let (squares, degrees) = about_mean(runs.clone().map(|(course, _)| course.sections[section]));
            self.squares += squares;
            self.degrees += degrees;
        }
    }

    /// Adds what another holds.
    pub fn merge(&mut self, other: &Self) {
        self.squares += other.squares;
        self.degrees += other.degrees;
        self.white_sq += other.white_sq;
        self.samples += other.samples;
        self.runs += other.runs;
    }

    /// Standard deviation of the noise from sample to sample; zero where nothing is known.
    pub fn white(&self) -> f64 {
        if self.runs > 0.0 { (self.white_sq / self.runs).sqrt() } else { 0.0 }
    }

    /// Root mean square of what differs between runs; `None` where nothing was repeated.
    pub fn floor(&self) -> Option<f64> {
        if !(self.degrees > 0.0) {
            return None;
        }
        let white_sq = self.white().powi(2);
        // A section's mean holds its share of the sample noise already.
        let in_section = (self.samples / self.runs / SECTIONS as f64).max(1.0);
        let between = (self.squares / self.degrees - white_sq / in_section).max(0.0);
        Some((between + white_sq).sqrt())
    }
}
