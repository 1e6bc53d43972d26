from tactogram_studio.pages.studies.joining import reachable_roots


def test_a_qr_code_leads_where_a_tablet_can_go():
    numbers = ("https://192.0.2.7:1", "https://198.51.100.7:1")
    assert (
        reachable_roots("https://127.0.0.1:1", numbers)
        == reachable_roots("https://127.0.0.2:1", numbers)
        == numbers
    )
    assert reachable_roots(numbers[1], numbers) == numbers[::-1]
    assert reachable_roots("https://lab.example", numbers) == (*numbers, "https://lab.example")
    assert reachable_roots("http://[::1]:1", ()) == ("http://[::1]:1",)
