//! Files of complementarity problems and of their answers.
//!
//! Little-endian without padding: `.lcp` holds dense problems, `.fac` contact problems by
//! their factors, `.res` answers with the times of the solves. See `docs/solver.md`.

use std::path::Path;

/// First four bytes of a `.lcp` file.
pub const DENSE_MAGIC: i32 = 0x4c43_5031;
/// First four bytes of a `.fac` file.
pub const FACTOR_MAGIC: i32 = 0x4c43_5046;

/// What is wrong with a file, and where.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The operating system refused.
    #[error("{file}: {source}")]
    Io {
        /// Which file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// The bytes are not such a file.
    #[error("{file}: byte {offset}: {reason}")]
    Malformed {
        /// Which file.
        file: String,
        /// Offset from the start of the file.
        offset: usize,
        /// What was found and what was expected.
        reason: String,
    },
}

/// Dense problems of one size.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DenseSet {
    /// Unknowns.
    pub n: usize,
    /// Contacts, 0 where these are no contact problems.
    pub contacts: usize,
    /// Whether every matrix is symmetric.
    pub symmetric: bool,
    /// Matrix (n x n, row by row) and constant (n) of each problem.
    pub problems: Vec<(Vec<f64>, Vec<f64>)>,
}

/// One contact problem by its factors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Factors {
    /// `5 contacts` x `freedoms`, row by row: normals, then t1, t2, -t1, -t2 of each contact.
    pub jacobian: Vec<f64>,
    /// Inverse mass of each degree of freedom, 1/kg or 1/(kg m^2).
    pub inverse_mass: Vec<f64>,
    /// Normal compliance of each contact, m/s per newton second.
    pub compliance: Vec<f64>,
    /// Coefficient of friction of each contact.
    pub friction: Vec<f64>,
    /// Constant of each of the `6 contacts` rows, m/s.
    pub constant: Vec<f64>,
}

/// Contact problems of one size.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FactorSet {
    /// Contacts.
    pub contacts: usize,
    /// Degrees of freedom.
    pub freedoms: usize,
    /// The problems.
    pub problems: Vec<Factors>,
}

/// What a problem file holds.
#[derive(Clone, Debug, PartialEq)]
pub enum ProblemFile {
    /// `.lcp`.
    Dense(DenseSet),
    /// `.fac`.
    Factors(FactorSet),
}

/// One answer as it is written to a `.res` file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// 0 claims a solution.
    pub status: i32,
    /// Pivots or factorisations.
    pub pivots: i32,
    /// Time of each repetition, microseconds.
    pub times_us: Vec<f64>,
    /// The unknowns.
    pub z: Vec<f64>,
}

struct Reader<'a> {
    file: String,
    bytes: &'a [u8],
    offset: usize,
}

impl Reader<'_> {
    fn fail<T>(&self, offset: usize, reason: impl Into<String>) -> Result<T, FileError> {
        Err(FileError::Malformed { file: self.file.clone(), offset, reason: reason.into() })
    }

    fn take(&mut self, length: usize, what: &str) -> Result<&[u8], FileError> {
        match self.bytes.get(self.offset..).and_then(|rest| rest.get(..length)) {
            Some(part) => {
                self.offset += length;
                Ok(part)
            }
            None => self.fail(
                self.offset,
                format!(
                    "{what} needs {length} bytes, the file ends after {}",
                    self.bytes.len().saturating_sub(self.offset)
                ),
            ),
        }
    }

    fn int(&mut self, what: &str) -> Result<i32, FileError> {
        let bytes = self.take(4, what)?;
        Ok(i32::from_le_bytes(bytes.try_into().unwrap_or_default()))
    }

    fn count(&mut self, what: &str, least: usize, most: usize) -> Result<usize, FileError> {
        let offset = self.offset;
        let value = self.int(what)?;
        match usize::try_from(value) {
            Ok(count) if (least..=most).contains(&count) => Ok(count),
            _ => self.fail(offset, format!("{what} is {value}, it must be {least} to {most}")),
        }
    }

    fn floats(&mut self, count: usize, what: &str) -> Result<Vec<f64>, FileError> {
        let bytes = self.take(8 * count, what)?;
        Ok(bytes
            .chunks_exact(8)
            .map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap_or_default()))
            .collect())
    }
}

/// Reads a `.lcp` or a `.fac` file; which one it is, its first four bytes tell.
///
/// Numbers that are not finite are read as they are: to judge them is the solver's task.
///
/// # Errors
/// The file cannot be read, or a header field or the length does not fit: byte offset and reason.
pub fn read(path: &Path) -> Result<ProblemFile, FileError> {
    let file = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|source| FileError::Io { file: file.clone(), source })?;
    parse(&file, &bytes)
}

/// Parses the bytes of a problem file; `file` is the name for errors.
///
/// # Errors
/// See [`read`].
pub fn parse(file: &str, bytes: &[u8]) -> Result<ProblemFile, FileError> {
    let mut reader = Reader { file: file.to_owned(), bytes, offset: 0 };
    let magic = reader.int("the magic number")?;
    let parsed = match magic {
        DENSE_MAGIC => {
            let number = reader.count("the number of problems", 0, 100_000_000)?;
            let n = reader.count("the number of unknowns", 1, 10_000)?;
            let contacts = reader.count("the number of contacts", 0, 10_000)?;
            let symmetric = reader.count("the symmetry flag", 0, 1)? == 1;
            reader.count("the last header field", 0, 0)?;
            let mut set = DenseSet { n, contacts, symmetric, problems: Vec::new() };
            for k in 0..number {
                let m = reader.floats(n * n, &format!("the matrix of problem {k}"))?;
                let q = reader.floats(n, &format!("the constant of problem {k}"))?;
                set.problems.push((m, q));
            }
            ProblemFile::Dense(set)
        }
        FACTOR_MAGIC => {
            let number = reader.count("the number of problems", 0, 100_000_000)?;
            let contacts = reader.count("the number of contacts", 1, 10_000)?;
            let freedoms = reader.count("the number of degrees of freedom", 1, 10_000)?;
            let mut set = FactorSet { contacts, freedoms, problems: Vec::new() };
            for k in 0..number {
                set.problems.push(Factors {
                    jacobian: reader
                        .floats(5 * contacts * freedoms, &format!("the Jacobian of problem {k}"))?,
                    inverse_mass: reader.floats(freedoms, &format!("the inverse masses of problem {k}"))?,
                    compliance: reader.floats(contacts, &format!("the compliances of problem {k}"))?,
                    friction: reader
                        .floats(contacts, &format!("the friction coefficients of problem {k}"))?,
                    constant: reader.floats(6 * contacts, &format!("the constants of problem {k}"))?,
                });
            }
            ProblemFile::Factors(set)
        }
        other => {
            return reader.fail(
                0,
                format!(
                    "the magic number is {other:#010x}, it must be {DENSE_MAGIC:#010x} (.lcp) \
                     or {FACTOR_MAGIC:#010x} (.fac)"
                ),
            );
        }
    };
    if reader.offset != bytes.len() {
        let offset = reader.offset;
        return reader.fail(offset, format!("{} bytes follow the last problem", bytes.len() - offset));
    }
    Ok(parsed)
}

/// Bytes of a `.lcp` file.
pub fn encode_dense(set: &DenseSet) -> Vec<u8> {
    let mut bytes = Vec::new();
    let header = [
        DENSE_MAGIC,
        set.problems.len() as i32,
        set.n as i32,
        set.contacts as i32,
        i32::from(set.symmetric),
        0,
    ];
    bytes.extend(header.iter().flat_map(|x| x.to_le_bytes()));
    for (m, q) in &set.problems {
        bytes.extend(m.iter().chain(q).flat_map(|x| x.to_le_bytes()));
    }
    bytes
}

/// Bytes of a `.fac` file.
pub fn encode_factors(set: &FactorSet) -> Vec<u8> {
    let mut bytes = Vec::new();
    let header = [FACTOR_MAGIC, set.problems.len() as i32, set.contacts as i32, set.freedoms as i32];
    bytes.extend(header.iter().flat_map(|x| x.to_le_bytes()));
    for p in &set.problems {
        let all = [&p.jacobian, &p.inverse_mass, &p.compliance, &p.friction, &p.constant];
        bytes.extend(all.into_iter().flatten().flat_map(|x| x.to_le_bytes()));
    }
    bytes
}

/// Bytes of a `.res` file: answers to problems of `n` unknowns.
pub fn encode_answers(n: usize, answers: &[Answer]) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend([answers.len() as i32, n as i32].iter().flat_map(|x| x.to_le_bytes()));
    for a in answers {
        let head = [a.status, a.pivots, a.times_us.len() as i32, 0];
        bytes.extend(head.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(a.times_us.iter().chain(&a.z).flat_map(|x| x.to_le_bytes()));
    }
    bytes
}

impl Factors {
    /// The dense form: `M` (n x n, row by row) and `q` (n) with n = 6 contacts.
    pub fn dense(&self) -> (Vec<f64>, Vec<f64>) {
        let contacts = self.friction.len();
        let (freedoms, n, rows) = (self.inverse_mass.len(), 6 * contacts, 5 * contacts);
        let mut m = vec![0.0; n * n];
        let row = |i: usize| &self.jacobian[i * freedoms..(i + 1) * freedoms];
        for i in 0..rows {
            for j in 0..rows {
                m[i * n + j] = row(i)
                    .iter()
                    .zip(row(j))
                    .zip(&self.inverse_mass)
                    .map(|((a, b), inverse)| a * inverse * b)
                    .sum();
            }
        }
        for i in 0..contacts {
            m[i * n + i] += self.compliance[i];
            m[(rows + i) * n + i] = self.friction[i];
            for k in 0..4 {
                let tangent = contacts + 4 * i + k;
                m[tangent * n + rows + i] = 1.0;
                m[(rows + i) * n + tangent] = -1.0;
            }
        }
        (m, self.constant.clone())
    }
}
