"""Spoilt TOML: files whose values, keys, tables and text are not what anybody meant."""

import copy
import json
import math
import tomllib

from fuzz_mutations import spoil_text


class Raw:
    """A value in TOML's own words."""

    def __init__(self, text):
        self.text = text


ODD = tuple(Raw(text) for text in (
    "nan", "inf", "-inf", "-nan", "0", "-0.0", "-1", "1", "2", "0.5", "1e308", "-1e308", "1e-320", "1e400",
    "1e9", "1e12", "1000000000", "100000000000000000000", "9007199254740993", str(2**63), str(10**400),
    "9" * 5000, "0x7fffffff", "true", "false", '""', '" "', '"x"', '"nan"', '"1e9"', '"1e99999"', '"2000/0"',
    '"1/3"', '"-60"', '"true"', '"../../up"', '"/"', '"."', '"a.b"', '"a.b.c"', '"a->b"', '"none"',
    '"\\u0000"', '"a\\u001b[31mb\\u0007\\u202e"', '"a\\nb"', '"\u65e5\u672c \u00e9\U0001f590"',
    f'"{"x" * 5000}"', "1979-05-27", "07:32:00", "1979-05-27T07:32:00Z", "[]", "{}", "[[]]", "[{}]", "[0.5]",
    "[nan]", "[inf, 1.0]", "[1, 2, 3]", "[[1.0, 2.0], [3.0]]", '["x"]', "[true]", "{x = 1}", '{"" = 1}',
    '{kind = "x"}', '{kind = 1}', '{file = "x"}', "{file = 1}", '{kind = "fixed", mean_ms = inf}',
    "[" * 60 + "]" * 60, "{a = " * 60 + "1" + "}" * 60, "[" * 3000 + "]" * 3000,
    ".".join(["{a"] + ["a"] * 300) + " = 1}", ".".join(["{a"] + ["a"] * 20000) + " = 1}"))
"""What replaces a value: other types, numbers at and beyond every end, odd texts, nesting."""
_FLOATS = (math.nan, math.inf, -math.inf, 0.0, -0.0, 1e-320, 1e-9, 1.0, -1.0, 1e9, 1e20, 1e154, 1e308, -1e308)
_FACTORS = (-1.0, 0.0, 1e-9, 1e-3, 0.1, 10.0, 1e3, 1e6, 1e9, 1e12)


def toml(document):
    """TOML text of tables, all below the first level on one line."""
    return "".join(f"{_quoted(key)} = {_value(value)}\n" for key, value in document.items())


def _value(value):
    if isinstance(value, Raw):
        return value.text
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_quoted(key)} = {_value(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    return _quoted(value) if isinstance(value, str) else str(value)


def _quoted(text):
    return json.dumps(text, ensure_ascii=True) if text.isascii() else json.dumps(text, ensure_ascii=False)


def places(value, path=()):
    """Paths of everything in tables and lists."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield (*path, key)
        yield from places(item, (*path, key))


def at(document, path):
    """What stands at a path."""
    for key in path:
        document = document[key]
    return document


def _replace(holder, key, document, paths, chance):
    holder[key] = chance.choice(ODD)


def _scale(holder, key, document, paths, chance):
    numbers = [path for path in paths if type(at(document, path)) in (int, float)]
    if numbers:
        path = chance.choice(numbers)
        holder, key = at(document, path[:-1]), path[-1]
        value = holder[key] * chance.choice(_FACTORS)
        holder[key] = chance.choice((float, int))(value) if abs(value) < 1e300 else value


def _number(holder, key, document, paths, chance):
    """A number of the same type, at or beyond an end of what it may be."""
    numbers = [path for path in paths if type(at(document, path)) in (int, float)]
    if numbers:
        path = chance.choice(numbers)
        holder = at(document, path[:-1])
        odd = (0, -1, 1, 2, 10**9, 2**31, 2**62, 2**63) if type(holder[path[-1]]) is int else _FLOATS
        holder[path[-1]] = chance.choice(odd)


def _drop(holder, key, document, paths, chance):
    del holder[key]


def _rename(holder, key, document, paths, chance):
    if isinstance(holder, dict):
        names = [path[-1] for path in paths if isinstance(path[-1], str)]
        new = chance.choice([*names, "", "a b", "a.b", "\x1b", "x" * 300, f"{key}s", key.upper()])
        holder[new] = holder.pop(key)


def _add(holder, key, document, paths, chance):
    if isinstance(holder, dict):
        names = [path[-1] for path in paths if isinstance(path[-1], str)]
        holder[chance.choice([*names, "unknown"])] = chance.choice(ODD)
    else:
        holder.insert(key, chance.choice((*ODD, holder[key])))


def _exchange(holder, key, document, paths, chance):
    """Two values, in each other's place: wires swapped, tables for numbers."""
    path = chance.choice(paths)
    other = at(document, path[:-1])
    holder[key], other[path[-1]] = copy.deepcopy(other[path[-1]]), copy.deepcopy(holder[key])


def _wrap(holder, key, document, paths, chance):
    value = holder[key]
    holder[key] = chance.choice(([value], {"x": value}, [value, value], _bare(value)))


def _bare(value):
    """What is in a table or a list, without it."""
    if isinstance(value, dict) and value:
        return next(iter(value.values()))
    return value[0] if isinstance(value, list) and value else str(value)


_CHANGES = (*(_replace, _number) * 3, _scale, _scale, _drop, _rename, _add, _exchange, _wrap)


def mutant(text, chance):
    """The text of a TOML file, spoilt: usually in its values and tables, sometimes in its words and lines."""
    if chance.random() < 0.1:
        return spoil_text(text.encode(), chance).decode("utf-8", "replace")
    document = tomllib.loads(text)
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        paths = list(places(document))
        if not paths:
            break
        path = chance.choice(paths)
        chance.choice(_CHANGES)(at(document, path[:-1]), path[-1], document, paths, chance)
    return toml(document)


def odd_setting(text, chance):
    """A `--set` of a file's own key, or of none, to something odd."""
    document = tomllib.loads(text)
    paths = [path for path in places(document) if path[0] not in ("variants", "guide")]
    aliases = list(document.get("aliases", {}))
    key = ".".join(str(part) for part in chance.choice(paths))
    if aliases and chance.random() < 0.5:
        key = chance.choice(aliases)
    if chance.random() < 0.1:
        key = chance.choice((f"{key}.x", "", ".", "..", "[0]", "a" * 5000, "blocks." + "a." * 20000 + "a",
                             "wires.0", "wires.99.latency_ms", f'{key}."', "blocks", "\x1b",
                             "blocks.\x00.kind"))
    return f"{key}={chance.choice(ODD).text}"
