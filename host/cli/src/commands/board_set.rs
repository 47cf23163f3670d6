//! What `stickslip board set` reads and sends: unit number, grip set-point and limits, poses without a host.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use serde::Deserialize;
use stickslip_device::Device;
use stickslip_device::error::reason;
use stickslip_shared::wire::{self, Grasp, GripLimits, Pose, check};

#[derive(Debug, clap::Args)]
pub struct SetArgs {
    /// Number of the unit
    #[arg(long, value_name = "NUMBER")]
    unit: Option<u32>,
    /// Grip force of each finger while no host commands one, N
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    grip: Option<f32>,
    /// Least grip that may be advised, N; limits that are not given with another one are the defaults
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    grip_least: Option<f32>,
    /// Most grip that may be advised, N: what object and gripper bear [default: 60]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    grip_most: Option<f32>,
    /// Fastest rise of the advised grip: what the gripper follows, N/s [default: 200]
    #[arg(long, value_name = "N/S", allow_negative_numbers = true)]
    grip_rise: Option<f32>,
    /// Fastest fall of it, N/s [default: 5]
    #[arg(long, value_name = "N/S", allow_negative_numbers = true)]
    grip_fall: Option<f32>,
    /// Poses without a host: a file with `[gripper]` and `[object]`, each `position_m` and `quaternion` (w, x, y, z)
    #[arg(long, value_name = "FILE.toml", conflicts_with = "no_grasp")]
    grasp: Option<PathBuf>,
    /// No poses without a host
    #[arg(long)]
    no_grasp: bool,
    /// Store it
    #[arg(long)]
    store: bool,
}

/// Checked, before a board is looked for.
#[derive(Debug)]
pub struct Set {
    unit: Option<u32>,
    grip_n: Option<f32>,
    limits: Option<GripLimits>,
    grasp: Option<Option<Grasp>>,
    /// The board shall keep it.
    pub store: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GraspFile {
    gripper: Placed,
    object: Placed,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Placed {
    #[serde(deserialize_with = "stickslip_data::exact::numbers")]
    position_m: [f32; 3],
    #[serde(deserialize_with = "stickslip_data::exact::numbers")]
    quaternion: [f32; 4],
}

impl SetArgs {
    /// # Errors
    /// Nothing is to be set, a number is out of its range, or the file is not one of poses.
    pub fn checked(&self) -> anyhow::Result<Set> {
        let usual = GripLimits::default();
        let given = [self.grip_least, self.grip_most, self.grip_rise, self.grip_fall];
        let limits = given.iter().any(Option::is_some).then(|| GripLimits {
            least_n: self.grip_least.unwrap_or(usual.least_n),
            most_n: self.grip_most.unwrap_or(usual.most_n),
            rise_n_s: self.grip_rise.unwrap_or(usual.rise_n_s),
            fall_n_s: self.grip_fall.unwrap_or(usual.fall_n_s),
        });
        let grasp = match &self.grasp {
            Some(file) => Some(Some(grasp(file)?)),
            None => self.no_grasp.then_some(None),
        };
        let set = Set { unit: self.unit, grip_n: self.grip, limits, grasp, store: self.store };
        ensure!(
            set.unit.is_some() || set.grip_n.is_some() || limits.is_some() || grasp.is_some(),
            "nothing to set: give --unit, --grip, --grip-least, --grip-most, --grip-rise, --grip-fall, --grasp or --no-grasp"
        );
        let checks = [
            ("--grip", set.grip_n.map(check::grip)),
            ("--grip-least, --grip-most, --grip-rise, --grip-fall", limits.as_ref().map(check::grip_limits)),
        ];
        for (option, checked) in checks {
            if let Some(Err(refusal)) = checked {
                bail!("{option}: {}", reason(&refusal));
            }
        }
        Ok(set)
    }
}

fn grasp(file: &Path) -> anyhow::Result<Grasp> {
    let named = || file.display().to_string();
    let text = std::fs::read_to_string(file).with_context(named)?;
    let GraspFile { gripper, object } = toml::from_str(&text).with_context(named)?;
    let pose = |of: Placed| Pose { position_m: of.position_m, quaternion: of.quaternion };
    let grasp = Grasp { gripper: pose(gripper), object: pose(object) };
    if let Err(refusal) = check::grasp(&grasp) {
        bail!("{}: {}", named(), reason(&refusal));
    }
    Ok(grasp)
}

impl Set {
    /// Sends it; what was set, in words.
    ///
    /// # Errors
    /// The board refuses it or does not answer.
    pub fn send(&self, device: &mut Device) -> anyhow::Result<Vec<String>> {
        let mut done = Vec::new();
        if let Some(number) = self.unit {
            device.command::<wire::SetUnit>(&number)?;
            done.push(format!("unit {number}"));
        }
        if let Some(force_n) = self.grip_n {
            device.command::<wire::SetGrip>(&force_n)?;
            done.push(format!("grip {force_n} N while no host commands one"));
        }
        if let Some(limits) = &self.limits {
            device.command::<wire::SetGripLimits>(limits)?;
            let GripLimits { least_n, most_n, rise_n_s, fall_n_s } = limits;
            done.push(format!(
                "advised grip {least_n} to {most_n} N, up {rise_n_s} N/s, down {fall_n_s} N/s"
            ));
        }
        if let Some(grasp) = &self.grasp {
            device.command::<wire::SetGrasp>(grasp)?;
            done.push(match grasp {
                Some(_) => "poses without a host".to_owned(),
                None => "no poses without a host".to_owned(),
            });
        }
        if self.store {
            device.command::<wire::Store>(&None)?;
            done.push("stored".to_owned());
        }
        Ok(done)
    }
}
