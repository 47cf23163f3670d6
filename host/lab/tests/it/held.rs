//! Scenes of `stickslip-lab cost`.

use stickslip_lab::held::Held;
use stickslip_lab::steps;
use stickslip_shared::model::{Base, Formulation, Friction, Model};
use stickslip_shared::solve::SolveStatus;

#[test]
fn an_object_at_rest_has_as_many_contact_points_as_its_scene_says_and_is_solved() {
    let friction = Friction { finger: 0.4, pusher: 0.25, support: 0.3 };
    for formulation in [Formulation::Cone, Formulation::Lcp] {
        let model = Model { formulation, ..Model::base(Base::Hard, friction) };
        for held in [Held::Prism, Held::Octagon, Held::Plate, Held::Bar] {
            let mut steps = 0;
            steps::walk(&held.package(&model, 50, 0.0), |walked| {
                steps += 1;
                assert_eq!(usize::from(walked.out.points), held.points(), "{held:?}");
                assert_eq!(walked.out.points_lost, 0, "{held:?}");
                assert_eq!(walked.out.status, SolveStatus::Solved, "{held:?}, step {steps}");
            });
            assert_eq!(steps, 49, "{held:?}");
        }
    }
}
