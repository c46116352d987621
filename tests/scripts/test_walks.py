"""The studies of laws for a bounded ankle: their wrong models, their rivals, and grounds that nobody else uses."""

from scripts.studies import recovery_search, soles_study


def test_no_ground_of_the_tables_is_a_training_ground() -> None:
    tables = {made(phase) for _, made in soles_study.grounds() for phase in range(soles_study.PHASES)}
    assert not tables & {*recovery_search.training(), *recovery_search.others()}
    assert not set(recovery_search.training()) & set(recovery_search.others())
    assert recovery_search.training() == recovery_search.training()
