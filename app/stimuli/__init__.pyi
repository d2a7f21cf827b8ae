from .stimulus import Stimulus
from .stimulus_file import load_stimuli, save_stimuli
from .stimulus_kinds import Babble, FingerPath, Grasp, Poke, Roll, Stroke, Tap
from .stimulus_player import StimulusPlayer

__all__ = [
    "Babble",
    "FingerPath",
    "Grasp",
    "Poke",
    "Roll",
    "Stimulus",
    "StimulusPlayer",
    "Stroke",
    "Tap",
    "load_stimuli",
    "save_stimuli",
]
