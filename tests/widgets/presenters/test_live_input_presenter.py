"""*File > Connect…*: what is asked for is connected, and what is wrong is said in the dialog."""

from __future__ import annotations

from widgets.context.connect_dialog import KINDS


def test_a_source_is_asked_for_and_connected(window, tmp_path):
    window.action("connect").trigger()
    dialog = window.presenters.live_input.dialog
    assert dialog.isVisible()
    assert dialog.address.text() == KINDS["UDP"]
    dialog.address.setText("udp://127.0.0.1:0")
    dialog.tare.setValue(20)
    dialog.go.click()
    assert not dialog.isVisible()
    assert window.live.live_input.session.facts.taring
    window.action("disconnect").trigger()
    assert window.live.live_input is None


def test_a_mistake_is_said_in_place(window, tmp_path):
    window.action("connect").trigger()
    dialog = window.presenters.live_input.dialog
    for kind, address, said in (
        ("File", str(tmp_path / "none.csv"), "none.csv"),
        ("File", " ", "no source is named"),
        ("UDP", "udp://0.0.0.0:9870", "or set a token, and let every packet carry it"),
        ("ROS 2", "ros2:", "need a mapping"),
    ):
        dialog.kind.setCurrentText(kind)
        dialog.address.setText(address)
        dialog.go.click()
        assert dialog.isVisible()
        assert said in dialog.problem.text()
    assert window.live.live_input is None
    dialog.kind.setCurrentText("Serial port")
    assert dialog.problem.isHidden()
    dialog.reject()
