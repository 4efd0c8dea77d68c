"""The page answers to itself alone: neither other sites, nor other names, nor without its token."""

import pytest

from worm_monitor.access import Access

HERE = Access("127.0.0.1", 8642)
OPEN = Access("0.0.0.0", 8642, "secret")


def refusal(access, host, origin=None, *, acts=False):
    headers = {"Host": host} | ({"Origin": origin} if origin is not None else {})
    return access.refusal(headers, acts=acts)


@pytest.mark.parametrize("host", ["127.0.0.1:8642", "localhost:8642", "127.0.0.2:8642"])
def test_this_machine_may_look(host):
    assert not refusal(HERE, host)
    assert not refusal(HERE, host, f"http://{host}", acts=True)


@pytest.mark.parametrize(
    "host",
    ["", "evil.example:8642", "127.0.0.1", "127.0.0.1:80", "localhost.evil.example:8642",
     "192.168.0.7:8642", "127.0.0.1:x", "127.0.0.1:8642@evil.example"],
)  # fmt: skip
def test_a_foreign_host_is_refused(host):
    assert refusal(HERE, host)


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "https://127.0.0.1:8642", "http://127.0.0.1:1", "null", "",
     "http://localhost:8642"],
)  # fmt: skip
def test_a_foreign_origin_is_refused(origin):
    assert refusal(HERE, "127.0.0.1:8642", origin, acts=True)
    assert refusal(HERE, "127.0.0.1:8642", origin)


def test_what_does_more_than_read_must_say_where_it_comes_from():
    assert refusal(HERE, "127.0.0.1:8642", acts=True)


def test_other_machines_come_by_number_or_this_machines_name_and_with_the_token():
    assert not refusal(OPEN, "192.168.0.7:8642")
    assert refusal(OPEN, "evil.example:8642")
    assert OPEN.opens("secret")
    assert not OPEN.opens("secre")
    assert not OPEN.opens("")
    assert not OPEN.opens("sécret")
    assert OPEN.address.endswith(":8642/secret/")


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.0.7", "rig.example"])
def test_a_page_that_other_machines_reach_has_a_token_that_nobody_guesses(host):
    first, second = Access.to(host, 8642), Access.to(host, 8642)
    assert len(first.token) >= 20
    assert first.token != second.token
    assert Access.to(host, 8642, "given").token == "given"


@pytest.mark.parametrize("host", ["127.0.0.1", "127.0.0.9", "::1"])
def test_a_page_for_this_machine_alone_needs_none(host):
    assert Access.to(host, 8642).token == ""
