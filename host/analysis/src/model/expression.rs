//! Expressions of a user's own effect: from text to the stack program that host and board
//! run (`stickslip_shared::effects::formula`).
//!
//! ```text
//! sum     = product { (+ | -) product }        a < b and a > b bind weakest and give 1 or 0
//! product = unary { (* | /) unary }
//! unary   = - unary | power
//! power   = atom [ (^ | **) unary ]            right to left, as in Python
//! atom    = number | pi | variable | parameter | function ( sum {, sum} ) | ( sum )
//! ```

use stickslip_shared::effects::formula::{FORMULA_PARAMETERS, Op, Variable};

/// What is wrong with an expression, and at which character (counted from 1).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("character {column}: {message}")]
pub struct ExpressionError {
    /// Counted from 1.
    pub column: usize,
    /// What is wrong and what would be right.
    pub message: String,
}

const UNARY: [(&str, Op<f64>); 9] = [
    ("abs", Op::Absolute),
    ("sqrt", Op::SquareRoot),
    ("exp", Op::Exponential),
    ("ln", Op::Logarithm),
    ("sin", Op::Sine),
    ("cos", Op::Cosine),
    ("tan", Op::Tangent),
    ("tanh", Op::HyperbolicTangent),
    ("sign", Op::Sign),
];
const BINARY: [(&str, Op<f64>); 3] = [("min", Op::Minimum), ("max", Op::Maximum), ("pow", Op::Power)];
/// Deepest nesting of brackets and signs; the program's stack is shallower still.
const MAX_NESTING: usize = 64;

struct Parser<'a> {
    text: Vec<char>,
    at: usize,
    nesting: usize,
    parameters: &'a [String],
    out: Vec<Op<f64>>,
}

/// The operations of `text`, in which `parameters` (at most four) may occur by name, or as
/// `p0` to `p3`.
pub fn parse(text: &str, parameters: &[String]) -> Result<Vec<Op<f64>>, ExpressionError> {
    let mut parser = Parser { text: text.chars().collect(), at: 0, nesting: 0, parameters, out: Vec::new() };
    parser.comparison()?;
    match parser.peek() {
        None => Ok(parser.out),
        Some(c) => {
            Err(parser
                .error(format!("'{c}' is not expected here; an operator is missing or a bracket too many")))
        }
    }
}

type Parsed = Result<(), ExpressionError>;

impl Parser<'_> {
    fn error(&self, message: String) -> ExpressionError {
        ExpressionError { column: self.at + 1, message }
    }

    fn peek(&mut self) -> Option<char> {
        while self.text.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn accept(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, wanted: char) -> Parsed {
        if self.accept(wanted) { Ok(()) } else { Err(self.error(format!("'{wanted}' is missing"))) }
    }

    fn comparison(&mut self) -> Parsed {
        self.nesting += 1;
        if self.nesting > MAX_NESTING {
            return Err(self.error("nested too deeply".into()));
        }
        self.sum()?;
        let op = match self.peek() {
            Some('<') => Some(Op::Less),
            Some('>') => Some(Op::Greater),
            _ => None,
        };
        if let Some(op) = op {
            self.at += 1;
            self.sum()?;
            self.out.push(op);
        }
        self.nesting -= 1;
        Ok(())
    }

    fn sum(&mut self) -> Parsed {
        self.product()?;
        loop {
            let op = match self.peek() {
                Some('+') => Op::Add,
                Some('-') => Op::Subtract,
                _ => return Ok(()),
            };
            self.at += 1;
            self.product()?;
            self.out.push(op);
        }
    }

    fn product(&mut self) -> Parsed {
        self.unary()?;
        loop {
            let op = match self.peek() {
                Some('*') => Op::Multiply,
                Some('/') => Op::Divide,
                _ => return Ok(()),
            };
            self.at += 1;
            let divisor = (self.at, self.out.len());
            self.unary()?;
            if op == Op::Divide && matches!(self.out.get(divisor.1..), Some([Op::Constant(0.0)])) {
                return Err(ExpressionError { column: divisor.0 + 1, message: "division by zero".into() });
            }
            self.out.push(op);
        }
    }

    fn unary(&mut self) -> Parsed {
        self.nesting += 1;
        if self.nesting > MAX_NESTING {
            return Err(self.error("nested too deeply".into()));
        }
        if self.accept('-') {
            self.unary()?;
            self.out.push(Op::Negate);
        } else {
            self.power()?;
        }
        self.nesting -= 1;
        Ok(())
    }

    fn power(&mut self) -> Parsed {
        self.atom()?;
        let caret = self.accept('^');
        let stars = !caret && self.peek() == Some('*') && self.text.get(self.at + 1) == Some(&'*');
        self.at += if stars { 2 } else { 0 };
        if caret || stars {
            self.unary()?;
            self.out.push(Op::Power);
        }
        Ok(())
    }

    fn atom(&mut self) -> Parsed {
        match self.peek() {
            None => Err(self.error("the expression ends where a value is expected".into())),
            Some('(') => {
                self.at += 1;
                self.comparison()?;
                self.expect(')')
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.name(),
            Some(c) => Err(self.error(format!("a value is expected, not '{c}'"))),
        }
    }

    fn number(&mut self) -> Parsed {
        let start = self.at;
        while let Some(c) = self.text.get(self.at) {
            let exponent_sign =
                matches!(c, '+' | '-') && matches!(self.text.get(self.at.wrapping_sub(1)), Some('e' | 'E'));
            if !(c.is_ascii_alphanumeric() || *c == '.' || exponent_sign) {
                break;
            }
            self.at += 1;
        }
        let text: String = self.text[start..self.at].iter().collect();
        match text.parse::<f64>() {
            Ok(x) if x.is_finite() => {
                self.out.push(Op::Constant(x));
                Ok(())
            }
            _ => Err(ExpressionError { column: start + 1, message: format!("'{text}' is not a number") }),
        }
    }

    fn name(&mut self) -> Parsed {
        let start = self.at;
        while self.text.get(self.at).is_some_and(|c| c.is_alphanumeric() || *c == '_') {
            self.at += 1;
        }
        let name: String = self.text[start..self.at].iter().collect();
        if let Some(k) = self.parameters.iter().position(|p| *p == name) {
            self.out.push(Op::Parameter(k as u8));
        } else if let Some((_, v)) = Variable::NAMES.iter().find(|(n, _)| *n == name) {
            self.out.push(Op::Variable(*v));
        } else if name == "pi" {
            self.out.push(Op::Constant(std::f64::consts::PI));
        } else if let Some((_, op)) = UNARY.iter().find(|(n, _)| *n == name) {
            self.expect('(')?;
            self.comparison()?;
            self.expect(')')?;
            self.out.push(*op);
        } else if let Some((_, op)) = BINARY.iter().find(|(n, _)| *n == name) {
            self.expect('(')?;
            self.comparison()?;
            self.expect(',')?;
            self.comparison()?;
            self.expect(')')?;
            self.out.push(*op);
        } else if let Some(k) =
            (0..FORMULA_PARAMETERS.min(self.parameters.len())).find(|k| name == format!("p{k}"))
        {
            self.out.push(Op::Parameter(k as u8));
        } else {
            return Err(ExpressionError { column: start + 1, message: self.unknown(&name) });
        }
        Ok(())
    }

    fn unknown(&self, name: &str) -> String {
        let list = |names: Vec<&str>| names.join(", ");
        format!(
            "unknown name '{name}'; variables: {}; functions: {}; parameters of this formula: {}",
            list(Variable::NAMES.iter().map(|(n, _)| *n).collect()),
            list(UNARY.iter().chain(&BINARY).map(|(n, _)| *n).collect()),
            if self.parameters.is_empty() { "none".into() } else { self.parameters.join(", ") }
        )
    }
}
