//! Stack programs (reverse Polish notation): what the host's parser makes of an expression and
//! both sides run.
//!
//! A program may have come over a wire, so it is checked before it is used, and it may meet any
//! numbers: every operation that has no value (a division by zero, the root of a negative number)
//! ends it with a [`Fault`], also where a later operation would hide it.

use crate::effect::MAX_PARAMETERS;
use crate::real::{Real, max, min, sqrt};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most operations of a program.
pub const MAX_OPS: usize = 48;
/// Deepest stack.
pub const MAX_STACK: usize = 12;
/// Parameters `p0` to `p3`.
pub const FORMULA_PARAMETERS: usize = 4;

/// What a formula may depend on. Friction sees the contact point (its rate of load: the whole
/// contact's); grip, added force and state see the mean over the bodies that touch (loads and their
/// rates: the sum).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Variable {
    /// Slip speed of the last step, m/s.
    SlipSpeed,
    /// Distance slipped, m.
    SlipDistance,
    /// Normal force of the whole contact, N.
    Load,
    /// Time since the point last slipped, s; zero for grip, force and state.
    Rest,
    /// Position on the object along its X axis, m; otherwise the object's in the gripper.
    PositionX,
    /// The same along Y.
    PositionY,
    /// The same along Z.
    PositionZ,
    /// Since the start of the trial, s.
    Time,
    /// Ordinal of the trial in its data set.
    Trial,
    /// Commanded grip, N.
    Grip,
    /// Change of the commanded grip since the last step, N/s.
    GripRate,
    /// Change of the load over the last step, N/s.
    LoadRate,
    /// Duration of the step, s.
    Step,
    /// What the formula remembers: zero at the start, then what its state expression gave.
    State,
}

impl Variable {
    /// Every variable with its name in expressions.
    pub const NAMES: [(&'static str, Variable); 14] = [
        ("slip_speed_m_s", Variable::SlipSpeed),
        ("slip_distance_m", Variable::SlipDistance),
        ("load_n", Variable::Load),
        ("rest_s", Variable::Rest),
        ("position_x_m", Variable::PositionX),
        ("position_y_m", Variable::PositionY),
        ("position_z_m", Variable::PositionZ),
        ("time_s", Variable::Time),
        ("trial", Variable::Trial),
        ("grip_n", Variable::Grip),
        ("grip_rate_n_s", Variable::GripRate),
        ("load_rate_n_s", Variable::LoadRate),
        ("dt_s", Variable::Step),
        ("state", Variable::State),
    ];
}

/// Values of the variables in the order of [`Variable`].
pub type Variables<R> = [R; Variable::NAMES.len()];

/// One operation. Binary operations take the deeper operand first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
#[allow(missing_docs)]
pub enum Op<R: Real> {
    Constant(R),
    Variable(Variable),
    /// `p0` to `p3`.
    Parameter(u8),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Minimum,
    Maximum,
    Less,
    Greater,
    Absolute,
    SquareRoot,
    Exponential,
    Logarithm,
    Sine,
    Cosine,
    Tangent,
    HyperbolicTangent,
    /// -1, 0 or 1.
    Sign,
}

/// Why a program is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormulaError {
    /// More than [`MAX_OPS`] operations.
    TooLong,
    /// More than [`MAX_STACK`] intermediate results.
    TooDeep,
    /// Operands missing or left over, or a parameter beyond `p3`.
    Malformed,
}

/// Why a program has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A division by zero, or a negative power of it.
    DivisionByZero,
    /// The root or logarithm of a number that has none, or a fractional power of a negative one.
    Domain,
    /// Beyond the largest number.
    Overflow,
    /// The program is malformed: [`Program::check`] refuses it.
    Malformed,
}

/// Operations in order of execution.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real", transparent)]
pub struct Program<R: Real>(pub Vec<Op<R>, MAX_OPS>);

impl<R: Real> Op<R> {
    /// Values taken from the stack.
    fn takes(&self) -> usize {
        match self {
            Op::Constant(_) | Op::Variable(_) | Op::Parameter(_) => 0,
            Op::Add
            | Op::Subtract
            | Op::Multiply
            | Op::Divide
            | Op::Power
            | Op::Minimum
            | Op::Maximum
            | Op::Less
            | Op::Greater => 2,
            _ => 1,
        }
    }
}

impl<R: Real> Program<R> {
    /// # Errors
    /// Programs that do not leave exactly one value, or break a limit.
    pub fn new(ops: &[Op<R>]) -> Result<Self, FormulaError> {
        let program = Self(Vec::from_slice(ops).map_err(|_| FormulaError::TooLong)?);
        program.check().map(|()| program)
    }

    /// Without operations: it has no value.
    pub fn none() -> Self {
        Self(Vec::new())
    }

    /// Whether some operation reads `variable`.
    pub fn reads(&self, variable: Variable) -> bool {
        self.0.iter().any(|op| matches!(op, Op::Variable(v) if *v == variable))
    }

    /// The same program in another scalar.
    pub fn cast<S: Real>(&self) -> Program<S> {
        let ops = self.0.iter().map(|op| match *op {
            Op::Constant(x) => Op::Constant(S::of(x.to_f64())),
            Op::Variable(v) => Op::Variable(v),
            Op::Parameter(k) => Op::Parameter(k),
            Op::Negate => Op::Negate,
            Op::Add => Op::Add,
            Op::Subtract => Op::Subtract,
            Op::Multiply => Op::Multiply,
            Op::Divide => Op::Divide,
            Op::Power => Op::Power,
            Op::Minimum => Op::Minimum,
            Op::Maximum => Op::Maximum,
            Op::Less => Op::Less,
            Op::Greater => Op::Greater,
            Op::Absolute => Op::Absolute,
            Op::SquareRoot => Op::SquareRoot,
            Op::Exponential => Op::Exponential,
            Op::Logarithm => Op::Logarithm,
            Op::Sine => Op::Sine,
            Op::Cosine => Op::Cosine,
            Op::Tangent => Op::Tangent,
            Op::HyperbolicTangent => Op::HyperbolicTangent,
            Op::Sign => Op::Sign,
        });
        Program(ops.collect())
    }

    /// # Errors
    /// Programs that cannot run.
    pub fn check(&self) -> Result<(), FormulaError> {
        let mut depth = 0_usize;
        for op in &self.0 {
            if matches!(op, Op::Parameter(k) if usize::from(*k) >= FORMULA_PARAMETERS) {
                return Err(FormulaError::Malformed);
            }
            depth = depth.checked_sub(op.takes()).ok_or(FormulaError::Malformed)?.saturating_add(1);
            if depth > MAX_STACK {
                return Err(FormulaError::TooDeep);
            }
        }
        if depth == 1 { Ok(()) } else { Err(FormulaError::Malformed) }
    }

    /// Value of the program, finite.
    ///
    /// # Errors
    /// An operation without a value, or a result beyond the largest number.
    pub fn evaluate(&self, p: &[R; MAX_PARAMETERS], variables: &Variables<R>) -> Result<R, Fault> {
        let mut stack: Vec<R, MAX_STACK> = Vec::new();
        for op in &self.0 {
            let value = apply(op, p, variables, &mut stack)?;
            stack.push(value).map_err(|_| Fault::Malformed)?;
        }
        match stack.as_slice() {
            [x] if x.finite() => Ok(*x),
            [_] => Err(Fault::Overflow),
            _ => Err(Fault::Malformed),
        }
    }
}

fn apply<R: Real>(
    op: &Op<R>,
    p: &[R; MAX_PARAMETERS],
    variables: &Variables<R>,
    stack: &mut Vec<R, MAX_STACK>,
) -> Result<R, Fault> {
    let (zero, one) = (R::zero(), R::one());
    let truth = |x: bool| if x { one } else { zero };
    let value = match op.takes() {
        0 => match *op {
            Op::Constant(x) => x,
            Op::Variable(v) => *variables.get(v as usize).ok_or(Fault::Malformed)?,
            Op::Parameter(k) => *p.get(usize::from(k)).ok_or(Fault::Malformed)?,
            _ => return Err(Fault::Malformed),
        },
        1 => {
            let x = stack.pop().ok_or(Fault::Malformed)?;
            match op {
                Op::Negate => -x,
                Op::Absolute => x.abs(),
                Op::SquareRoot if x < zero => return Err(Fault::Domain),
                Op::SquareRoot => sqrt(x),
                Op::Exponential => x.exp(),
                Op::Logarithm if x <= zero => return Err(Fault::Domain),
                Op::Logarithm => x.ln(),
                Op::Sine => x.sine_cosine().0,
                Op::Cosine => x.sine_cosine().1,
                Op::Tangent => {
                    let (sine, cosine) = x.sine_cosine();
                    if cosine == zero {
                        return Err(Fault::DivisionByZero);
                    }
                    sine / cosine
                }
                Op::HyperbolicTangent => x.tanh(),
                Op::Sign => truth(x > zero) - truth(x < zero),
                _ => return Err(Fault::Malformed),
            }
        }
        _ => {
            let b = stack.pop().ok_or(Fault::Malformed)?;
            let a = stack.pop().ok_or(Fault::Malformed)?;
            match op {
                Op::Add => a + b,
                Op::Subtract => a - b,
                Op::Multiply => a * b,
                Op::Divide if b == zero => return Err(Fault::DivisionByZero),
                Op::Divide => a / b,
                Op::Power if a == zero && b < zero => return Err(Fault::DivisionByZero),
                Op::Power => a.powf(b),
                Op::Minimum => min(a, b),
                Op::Maximum => max(a, b),
                Op::Less => truth(a < b),
                Op::Greater => truth(a > b),
                _ => return Err(Fault::Malformed),
            }
        }
    };
    // What no bound would catch: NaN, as the power of a negative number or the difference of two infinities.
    if value.partial_cmp(&value).is_none() { Err(Fault::Domain) } else { Ok(value) }
}
