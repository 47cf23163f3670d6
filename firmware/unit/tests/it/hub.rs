//! Several sensors on a unit's lines at once.

use proptest::prelude::*;
use stickslip_shared::wire::{Port, Sensor, Sensors};
use stickslip_unit::bus::{WRENCH_ID, Wrench};
use stickslip_unit::source::ati::Received;
use stickslip_unit::source::hub::{Hub, Measured};

use super::simulated::{Can, Netcanoem, Robotiq};

fn sensors(list: &[(Port, u8)]) -> Sensors {
    list.iter().map(|(port, finger)| Sensor { port: *port, finger: *finger }).collect()
}

fn netcanoem(base: u16) -> Netcanoem {
    Netcanoem { base, counts: [1; 2], units: [2, 3], matrix: [[1.0; 6]; 6], gauges: [1; 6], status: 0 }
}

fn tick(hub: &mut Hub, bus: &[Netcanoem], now_us: u32) -> Vec<Measured> {
    let asked: Vec<Can> = hub.requests(now_us).filter_map(|request| request.frame()).collect();
    let answers = asked.iter().flat_map(|asked| bus.iter().flat_map(|sensor| sensor.answer(asked)));
    answers
        .filter_map(|frame| Received::of(&frame).and_then(|r| hub.frame(r.id, r.data, now_us + 300)))
        .collect()
}

#[test]
fn what_arrives_goes_to_the_sensor_whose_it_is_and_comes_out_with_its_finger() {
    let bus = [netcanoem(5), netcanoem(6), netcanoem(7)];
    let mut hub = Hub::new();
    hub.assign(&sensors(&[(Port::Ati { base: 6 }, 0), (Port::Ati { base: 5 }, 1)]));
    let mut measured = Vec::new();
    for k in 0..20 {
        measured.extend(tick(&mut hub, &bus, k * 4000));
    }
    let of = |port, finger| measured.iter().filter(|m| (m.0, m.1) == (port, finger)).count();
    assert_eq!((of(Port::Ati { base: 6 }, 0), of(Port::Ati { base: 5 }, 1)), (12, 12));
    assert_eq!(measured.len(), 24);
    assert!(measured.iter().all(|m| m.2.values == [6.0; 6]));
}

#[test]
fn with_an_ati_sensor_the_bus_takes_classic_frames_only() {
    let mut hub = Hub::new();
    for (port, classic) in [(Port::Can, false), (Port::Ati { base: 5 }, true), (Port::Ft300, false)] {
        hub.assign(&sensors(&[(port, 1)]));
        assert_eq!(hub.is_classic(), classic, "{port:?}");
    }
}

#[test]
fn a_serial_sensor_and_one_on_the_bus_work_side_by_side() {
    let mut hub = Hub::new();
    hub.assign(&sensors(&[(Port::Can, 0), (Port::Ft300, 1)]));
    assert!(hub.has_serial());
    let wrench = Wrench { age_us: 0, period_us: 4000, counter: 0, valid: true, values: [2.0; 6] };
    let bus = hub.frame(WRENCH_ID, &wrench.encode(), 0).expect("of finger 1");
    assert_eq!((bus.0, bus.1), (Port::Can, 0));
    assert!(hub.frame(WRENCH_ID + 1, &wrench.encode(), 0).is_none(), "finger 2 is not measured on the bus");
    let found: Vec<_> = Robotiq::frame([1.0; 6]).into_iter().filter_map(|b| hub.byte(b, 9_000)).collect();
    assert!(matches!(found[..], [(Port::Ft300, 1, _)]));
}

#[test]
fn without_a_serial_sensor_its_bytes_are_nobodys() {
    let mut hub = Hub::new();
    assert!(!hub.has_serial());
    assert!(Robotiq::frame([1.0; 6]).into_iter().all(|b| hub.byte(b, 0).is_none()));
}

proptest! {
    #[test]
    fn any_assignment_and_traffic_are_survived(
        list in prop::collection::vec((0u8..4, any::<u8>(), any::<u8>()), 0..4),
        frames in prop::collection::vec((0u16..0x800, prop::collection::vec(any::<u8>(), 0..64)), 0..60),
    ) {
        let port = |kind, base| match kind {
            0 => Port::Gauges,
            1 => Port::Ft300,
            2 => Port::Ati { base },
            _ => Port::Can,
        };
        let list: Vec<_> = list.into_iter().map(|(kind, base, finger)| (port(kind, base), finger)).collect();
        let mut hub = Hub::new();
        hub.assign(&sensors(&list));
        for (k, (id, data)) in frames.iter().enumerate() {
            let _ = hub.requests(k as u32 * 4000).count();
            if let Some((_, finger, _)) = hub.frame(*id, data, k as u32 * 4000) {
                prop_assert!(list.iter().any(|(_, f)| *f == finger));
            }
        }
    }
}
