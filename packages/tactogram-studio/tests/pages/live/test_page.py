import os
import signal

from tactogram.datasets import open_store

SOURCE = "played:studio/first/surfaces?rate=330&loss=0.01&materials=all"
PLAN = """
title = "Two takes"
materials = ["carpet", "tile"]
seconds = 0.5
countdown_s = 0.1
order = "as-listed"
rate = 330
[limits]
most_lost = 1.0
longest_gap_s = 5.0
"""


def test_traces_two_takes_and_a_crash_between_them(browser, workspace, served, watched):
    (workspace / "two.toml").write_text(PLAN)
    arguments = ("studio", "--port", "0", "--no-open", "--folder", ".")
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    with (
        served(*arguments, folder=workspace, prefix="studio: ") as (process, address),
        watched(context, address) as tab,
    ):
        tab.goto(f"{address}/live")
        tab.get_by_label("Address").fill(SOURCE)
        tab.get_by_role("button", name="Listen", exact=True).click()
        tab.get_by_text("Hz measured").wait_for()
        assert "axes x, y, z" in tab.get_attribute("#live-traces", "aria-label")  # from the first figures on
        tab.wait_for_function("document.getElementById('live-traces').dataset.pictures > 20")
        with watched(context, address) as other:
            other.goto(f"{address}/live")
            other.get_by_text("this tab only watches").wait_for()
            other.wait_for_function("+document.getElementById('live-traces').dataset.samples > 100")
            assert other.get_by_role("button", name="Stop").count() == 0
            other.close()
        tab.get_by_role("button", name="Stop").click()
        tab.get_by_text("samples (simulated)").wait_for()

        tab.get_by_role("combobox", name="Plan").click()
        tab.get_by_role("option", name="two.toml").click()
        tab.get_by_label("Store (folder)").fill("rec")
        tab.get_by_role("button", name="Start or continue").click()
        tab.get_by_role("button", name="Begin (B)").wait_for()
        tab.keyboard.press("b")
        tab.get_by_role("button", name="Accept (A)").click()
        tab.get_by_role("region", name="Session").get_by_text("take 2 of 2").first.wait_for()
        tab.get_by_role("button", name="Begin (B)").wait_for()
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        tab.wrong.clear()
        tab.close()
        tab.wrong.clear()  # it asked a server that was gone
    assert [info.material for info in open_store(workspace / "rec").index] == ["carpet"]

    with (
        served(*arguments, folder=workspace, prefix="studio: ") as (_, address),
        watched(context, address) as tab,
    ):
        tab.goto(f"{address}/live")
        tab.get_by_text("1 of 2 takes are in the store").wait_for()
        tab.get_by_role("button", name="Continue the session").click()
        begin = tab.get_by_role("button", name="Begin (B)").element_handle()
        tab.get_by_text("Recording a session").wait_for()
        assert begin.evaluate("button => button.isConnected")  # redrawn, it would lose a click
        begin.click()
        tab.get_by_role("button", name="Accept (A)").wait_for()
        tab.close()  # nobody has to look for a take to stay
        with watched(context, address) as again:
            again.goto(f"{address}/live")
            again.get_by_role("region", name="Session").get_by_text("take 2 of 2").first.wait_for()
            again.get_by_role("button", name="Repeat (R)").click()
            again.get_by_text("-> redo").wait_for()
            again.get_by_role("button", name="Accept (A)").click()
            again.get_by_text("1 takes accepted, 1 repeated, 0 skipped, 0 left").wait_for()
            again.close()
    context.close()
    recorded = open_store(workspace / "rec")
    assert [info.material for info in recorded.index] == ["carpet", "tile"]
    assert recorded.simulated
