"""Random uses of `BinaryValue`, and what cocotb 1.9.2 gives for them: the file `binary_values.txt`.

    python binary_values.py          writes the file; needs cocotb 1.9.2
"""

import random
import warnings
from pathlib import Path

TABLE = Path(__file__).with_suffix(".txt")
COUNT = 100
UNSIGNED, TWOS_COMPLEMENT = 0, 2


def digits(rng, size):
    return "".join(rng.choice("01") for _ in range(size))


def value(rng, size, representation):
    """Returns a number that fits `size` digits, a text of other lengths too, or bytes."""
    kind = rng.choice(("number", "text", "bytes"))
    if kind == "text":
        return digits(rng, rng.randint(2, size + 4))
    if kind == "bytes":
        return rng.randbytes(rng.randint(1, 3))
    if representation == UNSIGNED:
        return rng.randrange(1 << size)
    return rng.choice((rng.randrange(1, 1 << size - 1), rng.randrange(-1 << size - 1, -1)))


def cases():
    """Yields the arguments of a `BinaryValue`, the value assigned to it later, and an index to read and to write."""
    rng = random.Random(19)
    for _ in range(COUNT):
        size, representation = rng.randint(2, 20), rng.choice((UNSIGNED, TWOS_COMPLEMENT))
        first, second = (value(rng, size, representation) for _ in range(2))
        yield (first, rng.choice((None, size)), rng.random() < 0.5, representation), second, rng.randrange(size)


def seen(binary):
    return binary.binstr, binary.integer, binary.signed_integer, binary.buff.hex(), len(binary)


def row(kind, case):
    """Returns what a class gives for a case, as a line."""
    arguments, second, at = case
    binary = kind(*arguments)
    found = [*seen(binary)]
    binary.assign(second)
    found += seen(binary)
    if binary.n_bits == len(binary) == arguments[1]:
        ends = sorted((at, len(binary) // 2), reverse=not arguments[2])
        found += [binary[at].binstr, binary[ends[0] : ends[1]].binstr]
        binary[at] = "1"
        found.append(binary.binstr)
    return " ".join(str(part) for part in found)


if __name__ == "__main__":
    from cocotb.binary import BinaryValue

    warnings.simplefilter("ignore")
    TABLE.write_text("".join(f"{row(BinaryValue, case)}\n" for case in cases()))
