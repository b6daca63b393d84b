use super::settings::COSTS;
use super::*;
use ballrace_core::network::Arithmetic::Fixed;
use ballrace_core::states::Alignment::{Causal, Forward, Half};
use ballrace_core::states::Estimator::Differences;
use ballrace_core::states::Orders::Consecutive;

#[path = "../../../../firmware-sim/tests/common/mod.rs"]
mod common;
use common::{KALMAN, SAVITZKY_GOLAY, SMALL, Sizes};

#[test]
fn every_kind_of_work_has_one_cost() {
    let listed: Vec<Work> = COSTS.iter().map(|row| row.work).collect();
    assert_eq!(listed, Work::ALL);
    for row in COSTS {
        let numbers = row.exact.iter().chain(&row.approx);
        assert!(numbers.clone().all(|n| n.is_finite() && *n >= 0.0), "{row:?}");
    }
}

fn of(sizes: Sizes, config: BudgetConfig) -> Budget {
    let bytes = common::model(sizes, &common::signal(400, 4));
    budget(&Model::from_bytes(&bytes).expect("a model"), config)
}

fn config(functions: Functions) -> BudgetConfig {
    BudgetConfig { functions, ..BudgetConfig::default() }
}

/// Cycles of an evaluated sample, traced by `firmware-sim/cycles.sh` on sizes that no cost was fitted to: exact, `approx`.
#[test]
fn golden_predictions_hold_on_sizes_not_fitted_to() {
    let networks = |dimension, latent, hidden, depth| Sizes { dimension, latent, hidden, depth, ..SMALL };
    for (sizes, [exact, approx]) in [
        (
            Sizes {
                degree: 2,
                harmonics: 2,
                powers: false,
                nonzeros: 77,
                equations: 1,
                alignment: Half,
                estimator: Differences,
                ..networks(8, 8, 110, 1)
            },
            [63361.5, 44027.9],
        ),
        (
            Sizes {
                degree: 2,
                harmonics: 0,
                powers: false,
                nonzeros: 30,
                equations: 3,
                alignment: Causal,
                estimator: Differences,
                ..networks(8, 8, 200, 1)
            },
            [99590.2, 66382.0],
        ),
        (
            Sizes {
                degree: 3,
                harmonics: 1,
                powers: false,
                nonzeros: 33,
                equations: 1,
                alignment: Forward,
                estimator: Differences,
                ..networks(10, 5, 80, 2)
            },
            [156825.8, 129904.0],
        ),
        (
            Sizes {
                degree: 5,
                harmonics: 2,
                powers: false,
                nonzeros: 6,
                equations: 1,
                alignment: Half,
                estimator: Differences,
                ..networks(1, 1, 9, 1)
            },
            [5592.9, 4167.7],
        ),
        (
            Sizes {
                degree: 1,
                harmonics: 4,
                powers: false,
                nonzeros: 40,
                equations: 2,
                orders: Consecutive,
                alignment: Half,
                estimator: Differences,
                ..networks(6, 6, 60, 1)
            },
            [38999.5, 27722.8],
        ),
        (
            Sizes {
                degree: 2,
                harmonics: 1,
                powers: true,
                nonzeros: 50,
                equations: 1,
                alignment: Causal,
                estimator: Differences,
                ..networks(7, 9, 44, 1)
            },
            [31341.9, 24152.0],
        ),
        (
            Sizes {
                degree: 2,
                harmonics: 0,
                powers: false,
                nonzeros: 45,
                equations: 1,
                alignment: Causal,
                estimator: SAVITZKY_GOLAY,
                ..networks(6, 8, 256, 1)
            },
            [129675.1, 87681.2],
        ),
        (
            Sizes {
                degree: 2,
                harmonics: 2,
                powers: false,
                nonzeros: 60,
                equations: 1,
                alignment: Causal,
                estimator: KALMAN,
                ..networks(8, 8, 37, 2)
            },
            [60182.2, 47421.0],
        ),
        (
            Sizes {
                arithmetic: Fixed,
                degree: 2,
                harmonics: 1,
                powers: false,
                nonzeros: 12,
                equations: 1,
                alignment: Half,
                estimator: Differences,
                ..networks(8, 8, 32, 1)
            },
            [7298.4, 7299.9],
        ),
        (
            Sizes {
                arithmetic: Fixed,
                degree: 2,
                harmonics: 0,
                powers: false,
                nonzeros: 25,
                equations: 1,
                alignment: Half,
                estimator: Differences,
                ..networks(10, 7, 51, 1)
            },
            [12020.0, 12291.0],
        ),
        (
            Sizes {
                arithmetic: Fixed,
                degree: 2,
                harmonics: 2,
                powers: false,
                nonzeros: 30,
                equations: 1,
                alignment: Causal,
                estimator: Differences,
                ..networks(4, 4, 100, 1)
            },
            [14861.0, 14429.2],
        ),
        (
            Sizes {
                arithmetic: Fixed,
                degree: 3,
                harmonics: 1,
                powers: false,
                nonzeros: 9,
                equations: 2,
                alignment: Causal,
                estimator: Differences,
                ..networks(2, 2, 26, 1)
            },
            [5044.3, 5063.3],
        ),
        (
            Sizes {
                arithmetic: Fixed,
                degree: 2,
                harmonics: 1,
                powers: false,
                nonzeros: 16,
                equations: 3,
                alignment: Forward,
                estimator: Differences,
                ..networks(14, 5, 128, 1)
            },
            [24585.6, 24595.1],
        ),
    ] {
        for (functions, traced) in [(Functions::Exact, exact), (Functions::Approx, approx)] {
            let predicted = of(sizes, config(functions)).cycles;
            let error: f64 = predicted / traced - 1.0;
            assert!(error.abs() < 0.05, "{functions:?}, n_MD {}: {predicted:.0}, traced {traced}", sizes.dimension);
        }
    }
}

#[test]
fn invariant_more_work_costs_more() {
    let cycles = |sizes| of(sizes, config(Functions::Exact)).cycles;
    let small = cycles(SMALL);
    for larger in [
        Sizes { dimension: 4, ..SMALL },
        Sizes { hidden: 13, ..SMALL },
        Sizes { depth: 2, ..SMALL },
        Sizes { nonzeros: 10, ..SMALL },
        Sizes { equations: 2, ..SMALL },
    ] {
        assert!(cycles(larger) > small);
    }
    let waiting = of(SMALL, BudgetConfig { wait_states: 5, ..BudgetConfig::default() });
    assert!(waiting.cycles > small && waiting.worst_cycles > waiting.cycles);
    assert!(of(SMALL, config(Functions::Approx)).cycles < small);
}

#[test]
fn stages_add_up_and_a_limit_is_named() {
    let budget = of(SMALL, BudgetConfig::default());
    let sum: f64 = budget.stages.iter().map(|stage| stage.cycles).sum();
    assert!((sum - budget.cycles).abs() < 1e-6 * sum && budget.worst_cycles >= budget.cycles);
    let needed = budget.worst_cycles.ceil() as usize;
    assert_eq!(budget.check_cycles(needed), Ok(()));
    let refused = budget.check_cycles(needed - 1).expect_err("a cycle too many").to_string();
    assert!(refused.contains("cycle limit") && refused.contains(&format!("at most {}", needed - 1)), "{refused}");
    assert_eq!(Budget::period_cycles(168e6, 25_600.0), 6562.5);
}
