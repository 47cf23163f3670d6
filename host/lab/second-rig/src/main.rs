//! `stickslip-second-rig`: draws data sets of the second reality.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use stickslip_second_rig::dataset::{Chosen, DataSet, Wish};
use stickslip_second_rig::families::{FAMILIES, Family};
use stickslip_second_rig::hidden::CATALOGUE;
use stickslip_second_rig::{Error, write};

/// Draws data sets from an independent second reality: bristle patches on viscoelastic pads.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// List the families
    Families,
    /// List the hidden effects
    Effects,
    /// Draw one data set, or several with consecutive seeds, each with its key apart
    Draw {
        /// Everything follows from it
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// See `families`; 'all' takes one after the other
        #[arg(long, default_value = "bench-wide")]
        family: String,
        /// Folder of the data set; with --count, of all data sets
        #[arg(long)]
        out: PathBuf,
        /// Number of data sets: OUT/FAMILY-SEED
        #[arg(long)]
        count: Option<u64>,
        /// File of the key [default: OUT.key.json]; with --count, a folder [default: OUT.keys]
        #[arg(long)]
        key: Option<PathBuf>,
        /// Hidden effect in place of a drawn one, NAME or NAME=LEVEL (1 is typical); may be given
        /// several times; 'none' for nothing hidden
        #[arg(long)]
        effect: Vec<String>,
        /// Most trials of a bench, number of trials of grasps
        #[arg(long)]
        trials: Option<usize>,
    },
}

fn main() -> ExitCode {
    match run(Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> Result<(), Error> {
    match command {
        Command::Families => {
            for f in FAMILIES {
                println!("{:<20} {}", f.name, f.what);
            }
            Ok(())
        }
        Command::Effects => {
            for e in CATALOGUE {
                let primitives: Vec<_> = e.shows_in.iter().map(|p| format!("{p:?}")).collect();
                println!("{:<26} {} ({})", e.id, e.what, primitives.join(", "));
            }
            Ok(())
        }
        Command::Draw { seed, family, out, count, key, effect, trials } => {
            let wish = Wish { effects: wished(&effect)?, trials };
            let beside = |end: &str| {
                let mut name = out.clone().into_os_string();
                name.push(end);
                PathBuf::from(name)
            };
            let Some(count) = count else {
                let key = key.unwrap_or_else(|| beside(".key.json"));
                return draw(named(&family)?, seed, &wish, &out, &key);
            };
            let keys = key.unwrap_or_else(|| beside(".keys"));
            for i in 0..count {
                let family =
                    if family == "all" { &FAMILIES[i as usize % FAMILIES.len()] } else { named(&family)? };
                let seed = seed + i;
                let name = format!("{}-{seed}", family.name);
                draw(family, seed, &wish, &out.join(&name), &keys.join(format!("{name}.json")))?;
            }
            Ok(())
        }
    }
}

fn named(name: &str) -> Result<&'static Family, Error> {
    Family::named(name).ok_or_else(|| Error::UnknownFamily(name.to_owned()))
}

fn wished(list: &[String]) -> Result<Option<Chosen>, Error> {
    if list.is_empty() {
        return Ok(None);
    }
    let mut out = Vec::new();
    for text in list.iter().filter(|t| *t != "none") {
        out.push(match text.split_once('=') {
            None => (text.clone(), None),
            Some((name, level)) => {
                let level = level.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
                (name.to_owned(), Some(level.ok_or_else(|| Error::BadEffect(text.clone()))?))
            }
        });
    }
    Ok(Some(out))
}

fn draw(family: &'static Family, seed: u64, wish: &Wish, out: &Path, key: &Path) -> Result<(), Error> {
    let set = DataSet::draw(family, seed, wish)?;
    let runs = set.run();
    write::write(&set, &runs, out, key)?;
    let seconds: f64 = runs.iter().filter_map(|r| r.rows.last()).map(|r| r.t_s).sum();
    println!("{}: {} trials, {seconds:.0} s of data; key: {}", out.display(), runs.len(), key.display());
    Ok(())
}
