from .ablation import ablation_cost
from .catalogue import STUDY_NAMES, load_study
from .controller_comparison import Contender, compare_controllers, controller_metrics, trace_csv
from .running.case_run import run_cases
from .study import Study
from .work_precision import Setting, Subject, Trial, diagram, pareto_front, run_trials

__all__ = [
    "STUDY_NAMES",
    "Contender",
    "Setting",
    "Study",
    "Subject",
    "Trial",
    "ablation_cost",
    "compare_controllers",
    "controller_metrics",
    "diagram",
    "load_study",
    "pareto_front",
    "run_cases",
    "run_trials",
    "trace_csv",
]
