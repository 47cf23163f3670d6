//! Contact law of one patch: stiffness, and friction with everything that can modify it.

/// Stiffness and damping of one whole contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// N/m.
    pub normal: f64,
    /// N/m.
    pub tangential: f64,
    /// N s/m.
    pub normal_damping: f64,
    /// N s/m.
    pub tangential_damping: f64,
}

impl Stiffness {
    /// Kelvin-Voigt contact with the same damping time in both directions.
    pub fn new(normal_n_m: f64, tangential_n_m: f64, damping_s: f64) -> Self {
        Self {
            normal: normal_n_m,
            tangential: tangential_n_m,
            normal_damping: normal_n_m * damping_s,
            tangential_damping: tangential_n_m * damping_s,
        }
    }
}

/// What a patch remembers of its history.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Memory {
    /// Normal force at the last step, N.
    pub normal_n: f64,
    /// Mean slip distance since the start, m.
    pub slip_m: f64,
    /// Energy dissipated since the start, J.
    pub work_j: f64,
    /// Age of the contact (rate and state: grows at rest, is worn off by slip), s.
    pub age_s: f64,
}

impl Memory {
    pub(super) fn advance(&mut self, normal_n: f64, slip_m_s: f64, power_w: f64, law: &FrictionLaw, dt: f64) {
        self.normal_n = normal_n;
        self.slip_m += slip_m_s * dt;
        self.work_j += power_w * dt;
        let renewal = (slip_m_s / law.ageing_slip_m * dt).min(1.0);
        self.age_s += dt - self.age_s * renewal;
    }
}

/// Friction of one patch. Every modifier is off at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionLaw {
    /// Coulomb coefficient.
    pub mu: f64,
    /// Break-away over sliding friction, less one.
    pub break_away: f64,
    /// Speed at which break-away has decayed by a factor e, m/s.
    pub break_away_speed_m_s: f64,
    /// Time in which a point forgets how fast it slid, s.
    pub speed_memory_s: f64,
    /// Viscous resistance of the whole patch, N s/m.
    pub viscous_n_s_m: f64,
    /// Relative gain of friction per e-fold of the contact's age.
    pub ageing: f64,
    /// Slip that renews the contact, m.
    pub ageing_slip_m: f64,
    /// Age at which strengthening sets in, s.
    pub ageing_onset_s: f64,
    /// mu falls with the load to this power.
    pub load_exponent: f64,
    /// Load at which mu has its nominal value, N.
    pub load_reference_n: f64,
    /// Relative difference of friction along and across the lay.
    pub anisotropy: f64,
    /// Direction of the lay in the tangent plane (set at each step), unit vector `a, b`.
    pub lay_axis: [f64; 2],
    /// Load that adhesion adds to the normal force, N.
    pub adhesion_n: f64,
    /// Relative amplitude of friction that repeats with slip distance.
    pub periodic: f64,
    /// Slip distance of one period, m.
    pub period_m: f64,
    /// Share of friction lost after much frictional work.
    pub fade: f64,
    /// Work at which the loss has reached 63 %, J.
    pub fade_work_j: f64,
    /// Relative change of friction inside a stripe of the object's face.
    pub stripe: f64,
    /// Where the stripe begins and ends along the lay, in the patch's coordinates (set at each step), m.
    pub stripe_span_m: [f64; 2],
    /// Relative change of friction for each metre along `b`.
    pub gradient_b_per_m: f64,
}

impl FrictionLaw {
    /// Plain Coulomb friction.
    pub fn coulomb(mu: f64) -> Self {
        Self {
            mu,
            break_away: 0.0,
            break_away_speed_m_s: 2e-3,
            speed_memory_s: 3e-3,
            viscous_n_s_m: 0.0,
            ageing: 0.0,
            ageing_slip_m: 5e-5,
            ageing_onset_s: 0.1,
            load_exponent: 0.0,
            load_reference_n: 20.0,
            anisotropy: 0.0,
            lay_axis: [1.0, 0.0],
            adhesion_n: 0.0,
            periodic: 0.0,
            period_m: 2.5e-3,
            fade: 0.0,
            fade_work_j: 0.03,
            stripe: 0.0,
            stripe_span_m: [0.0, 0.0],
            gradient_b_per_m: 0.0,
        }
    }

    /// Whether nothing but Coulomb friction acts.
    pub fn is_plain(&self) -> bool {
        [
            self.break_away,
            self.viscous_n_s_m,
            self.ageing,
            self.load_exponent,
            self.anisotropy,
            self.adhesion_n,
            self.periodic,
            self.fade,
            self.stripe,
            self.gradient_b_per_m,
        ]
        .iter()
        .all(|x| *x == 0.0)
    }

    /// Factor on friction that all points of a patch share.
    pub(super) fn patch_factor(&self, memory: &Memory) -> f64 {
        let mut factor = 1.0;
        if self.ageing != 0.0 {
            factor *= 1.0 + self.ageing * (memory.age_s / self.ageing_onset_s).ln_1p();
        }
        if self.load_exponent != 0.0 {
            let load = (memory.normal_n / self.load_reference_n).clamp(1e-3, 1e3);
            factor *= load.powf(-self.load_exponent);
        }
        if self.periodic != 0.0 {
            let phase = std::f64::consts::TAU * memory.slip_m / self.period_m;
            factor *= 1.0 + self.periodic * phase.sin();
        }
        if self.fade != 0.0 {
            factor *= 1.0 - self.fade * (1.0 - (-memory.work_j / self.fade_work_j).exp());
        }
        factor.max(0.0)
    }

    /// Factor on friction of a point at `(a, b)` that slid at `speed`.
    pub(super) fn point_factor(&self, speed: f64, a: f64, b: f64) -> f64 {
        let mut factor = 1.0;
        if self.break_away != 0.0 {
            factor += self.break_away * (-speed / self.break_away_speed_m_s).exp();
        }
        if self.stripe != 0.0 {
            let along = self.lay_axis[0] * a + self.lay_axis[1] * b;
            if along >= self.stripe_span_m[0] && along <= self.stripe_span_m[1] {
                factor *= 1.0 + self.stripe;
            }
        }
        (factor * (1.0 + self.gradient_b_per_m * b)).max(0.0)
    }

    /// Friction along and across the lay over the mean.
    pub(super) fn lay_stretch(&self) -> [f64; 2] {
        [(1.0 + self.anisotropy / 2.0).max(0.05), (1.0 - self.anisotropy / 2.0).max(0.05)]
    }
}
