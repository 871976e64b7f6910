from cell.assembly.twin import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import Profile, load_profile
from cell.store import StorePlan, StoreSlot, TablePlace, place_of_slot, with_calibration_object


def test_the_plan_of_a_cell_has_the_calibration_object_at_its_slot() -> None:
    profile = load_profile("mash")
    plan = with_calibration_object(StorePlan(()), profile.store)
    slot = plan.slot(19)
    place = place_of_slot(slot, profile.store)
    assert (slot.kind, slot.colour, place.x_mm, place.y_mm) == ("cylinder", "natural", 135.0, 350.0)


def test_a_plan_that_has_the_number_already_and_a_store_without_an_object_stay() -> None:
    profile = load_profile("mash")
    own = StorePlan((StoreSlot(number=19, kind="cube", colour="red", x_mm=1.0, y_mm=2.0),))
    assert with_calibration_object(own, profile.store) is own
    bare = profile.store.model_copy(update={"calibration": None})
    assert with_calibration_object(StorePlan(()), bare) == StorePlan(())


def test_the_arm_fetches_the_calibration_object_and_brings_it_home() -> None:
    profile: Profile = load_profile("mash")
    cell = assemble_twin(profile, StorePlan(()), seed=1, clock=SimulatedClock())
    try:
        cell.open()
        cell.deploy(19, TablePlace(x_mm=500.0, y_mm=0.0, yaw_deg=0.0))
        (block,) = cell.world.blocks.all()
        assert abs(block.x_mm - 500.0) < 2.0
        assert abs(block.y_mm) < 2.0
        assert cell.clean() == [19]
    finally:
        cell.dispose()
