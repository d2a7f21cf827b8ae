"""Faulty plug-ins, one for each kind of fault."""

import numpy as np

from tactile_maps.control.controller_registry import ControllerEntry
from tactile_maps.control.controllers import ImpedanceController
from tactile_maps.control.motion.command import JointCommand
from tactile_maps.flattening.methods import Method
from tactile_maps.skin.formats.taxel_files import TaxelFormat
from tactile_maps.tactile.models.contact_model import ContactModelEntry
from tactile_maps.tactile.sensors.sensor_chain import SensorStageEntry
from tactile_maps.tactile.sensors.sensor_effects import SensorStage


def _fail(disk, lengths):
    yield disk.start
    raise ZeroDivisionError("by a stranger")


TUTTE = Method("tutte", "the name of a built-in one", _fail)
WRONG_CALL = Method("wrong-call", "takes one argument", lambda disk: iter(()))
WRONG_KIND = {"name": "wrong-kind"}
FAILING = Method("failing", "fails at work", _fail)
SHORT = Method("short", "too few vertices", lambda disk, lengths: iter([np.zeros((2, 2))]))
EMPTY_HANDED = ContactModelEntry("empty-handed", "Empty", "Builds no model.", lambda skin, layer, sensor: object())


class _Deaf(SensorStage):
    def read(self, pressures):
        return pressures[:1]


class _Runaway(ImpedanceController):
    def command(self, settings, observation):
        posture = observation.posture
        return JointCommand(posture * np.nan, posture, posture, posture)


NOWHERE = SensorStageEntry("nowhere", "Nowhere", "Before nothing", lambda readout, options: _Deaf(), before="bus")
NOISE = SensorStageEntry("noise", "Noise", "A built-in one's name", lambda readout, options: _Deaf())
ILL_NOISE = SensorStageEntry(
    "ill-noise", "Noise", "Of no number", lambda readout, options: _Deaf(), noise=lambda options: -1.0
)
DEAF = SensorStageEntry("deaf", "Deaf", "Too few readings", lambda readout, options: _Deaf())
NO_SETTING = ControllerEntry("no-setting", "No setting", "", lambda *built_of: None, ("colour",))
RUNAWAY = ControllerEntry("runaway", "Runaway", "No numbers", lambda robot, tasks, map_kinematics: _Runaway(robot))
TAKEN = TaxelFormat("taken", "Tables", (".csv",), lambda path: ())
