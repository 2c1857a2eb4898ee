"""Random streams: no two uses of a seed share one."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.streams import Stream, stream

# Small numbers, where zeros and lengths are confused, and those about the end of a 32-bit word.
INDEX = st.integers(0, 3) | st.integers(2**32 - 5, 2**32 - 2)
USES = st.tuples(st.sampled_from(Stream), st.lists(INDEX, max_size=6).map(tuple))


def state(generator):
    return generator.bit_generator.state["state"]["state"]


@given(seeds, USES, USES)
def test_two_uses_share_a_stream_only_if_they_are_the_same(seed, one, other):
    (name, index), (other_name, other_index) = one, other
    same = state(stream(seed, name, *index)) == state(stream(seed, other_name, *other_index))
    assert same == (one == other)


def test_short_indices_of_every_length_give_streams_that_differ():
    uses = [(n, *k) for n in Stream for length in range(5) for k in itertools.product(range(3), repeat=length)]
    assert len({state(stream(1, *use)) for use in uses}) == len(uses)


@given(seeds, seeds, USES)
def test_seeds_share_a_stream_only_if_they_are_the_same(one, other, use):
    name, index = use
    assert (state(stream(one, name, *index)) == state(stream(other, name, *index))) == (one == other)


def test_children_of_a_stream_are_not_the_streams_of_longer_indices():
    """An execution of the search draws from a child of the arm's stream."""
    children = {state(child) for child in stream(1, Stream.SEARCH, 2).spawn(5)}
    longer = [k for length in range(4) for k in itertools.product(range(6), repeat=length)]
    assert not children & {state(stream(1, Stream.SEARCH, 2, *k)) for k in longer}


@pytest.mark.parametrize(("seed", "index"), [(-1, ()), (2**32, ()), (0, (-1,)), (0, (0, 2**32 - 1))])
def test_numbers_that_do_not_fit_are_refused(seed, index):
    with pytest.raises(ValueError, match=r"seed, index: .* 32 bits"):
        stream(seed, Stream.SEARCH, *index)
