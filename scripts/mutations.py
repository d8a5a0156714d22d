# SPDX-License-Identifier: MIT
"""Mutations of C code, found by its text: single changes that a test should notice (scripts/mutate)."""
import collections
import re

# start, end: the replaced range of the file's text
Mutation = collections.namedtuple("Mutation", "kind start end text")

IGNORED_CALLS = re.compile(r"\b(?:assert|static_assert|_Static_assert|stp_fail|stp_fail_memory|stp_warn|stp_notice)\(")
COMMENT_OR_LITERAL = re.compile(r"""//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'""", re.S)
DIRECTIVE = re.compile(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.M)
DEBUG_ONLY = re.compile(r"^#ifndef NDEBUG\n.*?^#endif", re.M | re.S)

# clang-format puts spaces around binary operators only
OTHER_OPERATORS = {
    "comparison": {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="},
    "arithmetic": {"+": "-", "-": "+"},
    "logic": {"&&": "||", "||": "&&"},
}
OPERATOR = re.compile(r"(?<= )(?:<=|>=|==|!=|&&|\|\||[-+<>])(?=[ \n])")
OTHER_FUNCTIONS = {
    "stp_min": "stp_max", "stp_max": "stp_min", "stp_maxd": "fmin",
    "fmin": "fmax", "fmax": "fmin", "fminf": "fmaxf", "fmaxf": "fminf",
}
FUNCTION = re.compile(r"\b(?:%s)(?=\()" % "|".join(OTHER_FUNCTIONS))
NUMBER = re.compile(r"(?<![\w.])(?:0[xX][0-9a-fA-F]+|\d+(?:\.\d+)?)(?=[uUlLfF]*(?![\w.]))")
CONDITION = re.compile(r"\bif \(")
# an assignment, an increment or a call; declarations have two words in a row
STATEMENT = re.compile(r"(?<=[;{}]\n)( {4,})(?!return\b|else\b|case\b|goto\b)"
                       r"((?:\*|\()*[a-z_]\w*(?:(?:->|\.)\w+|\[[^\];]*\])*\)?"
                       r"(?: (?:[-+*/|&^%]|<<|>>)?= |\(|\+\+|--)[^;{}]*;)")


def blank(text, start, end):
    """Spaces instead of a range, which keep their lines."""
    return text[:start] + re.sub(r"[^\n]", " ", text[start:end]) + text[end:]


def closing_parenthesis(text, opening):
    depth = 0
    for at in range(opening, len(text)):
        depth += (text[at] == "(") - (text[at] == ")")
        if depth == 0:
            return at
    return len(text) - 1


def visible_code(text):
    """The text with everything blanked that is not mutated, so positions stay."""
    for pattern in (COMMENT_OR_LITERAL, DEBUG_ONLY, DIRECTIVE):
        for match in pattern.finditer(text):
            text = blank(text, *match.span())
    for match in IGNORED_CALLS.finditer(text):
        text = blank(text, match.start(), closing_parenthesis(text, match.end() - 1) + 1)
    return text


def neighbour_numbers(literal):
    if literal.lower().startswith("0x"):
        value = int(literal, 16)
        return [hex(value + 1)] + ([hex(value - 1)] if value else [])
    whole, point, fraction = literal.partition(".")
    value = int(whole)
    return [f"{near}{point}{fraction}" for near in (value + 1, value - 1) if near >= 0]


def find_mutations(text):
    """All mutations of a source file, in a fixed order."""
    code = visible_code(text)
    for match in OPERATOR.finditer(code):
        for kind, others in OTHER_OPERATORS.items():
            if match[0] in others:
                yield Mutation(kind, *match.span(), others[match[0]])
    for match in FUNCTION.finditer(code):
        yield Mutation("extremum", *match.span(), OTHER_FUNCTIONS[match[0]])
    for match in NUMBER.finditer(code):
        for near in neighbour_numbers(match[0]):
            yield Mutation("number", *match.span(), near)
    for match in CONDITION.finditer(code):
        opening = match.end() - 1
        closing = closing_parenthesis(code, opening)
        yield Mutation("condition", opening, closing + 1, "(!" + text[opening:closing + 1] + ")")
    for match in STATEMENT.finditer(code):
        yield Mutation("statement", *match.span(2), ";")
