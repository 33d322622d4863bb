# SPDX-License-Identifier: Apache-2.0
"""The limits of CONTRIBUTING.md: lines of files, headers and functions, outlines of long functions, and
how a file begins.

    limits.py [FOLDER]

Names everything that is beyond a limit and every exception (limits.txt) that is not needed or too
small, so that their list only shrinks. Without FOLDER: this repository.
"""

import os
import re
import sys
from pathlib import Path

FILE, HEADER, FUNCTION = 400, 150, 40  # everything stays below these numbers of lines
OUTLINE = 25  # a function of so many lines has a comment of its own line inside
SOURCES, HEADERS, SCRIPTS = (".cpp", ".cu"), (".hpp", ".cuh"), (".py",)

# comments, texts, letters and lines of the preprocessor: braces in them are none
NO_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"([^\s()\\]{0,16})\(.*?\)\1"|"(?:\\.|[^"\\\n])*"'
    r"|(?<![0-9a-zA-Z_])'(?:\\.|[^'\\\n])+'|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.DOTALL | re.MULTILINE)
ANGLES = r"<(?:[^<>(){};]|<(?:[^<>(){};]|<[^<>(){};]*>)*>)*>"
# words and signs that may precede the first word of a declaration
BEFORE = re.compile(rf"(?:\s+|template\s*{ANGLES}|requires\s+\w+{ANGLES}|(?:public|private|protected)\s*:"
                    r"|\[\[.*?\]\])*", re.DOTALL)
ATTRIBUTE = re.compile(r"\b(?:alignas|__launch_bounds__|decltype)\s*\((?:[^()]|\([^()]*\))*\)")
SCOPE = re.compile(r'^(?:inline\s+)?namespace\b|^extern\s+""$|^(?:\w+\s+)*(?:class|struct|union)\b[^)]*$')
# the name of a member that a constructor begins in braces
MEMBER = re.compile(r"\)\s*(?:noexcept\s*)?:\s.*[\w>]$", re.DOTALL)
NAME = re.compile(r"((?:\w+::)*operator\s*(?:\(\)|[^\s\w(]+|\w+)|[\w:~]+)\s*\(")
TEST = re.compile(r"\bTEST(?:_F|_P)?\s*\(\s*(\w+),\s*(\w+)\s*\)")


def code_of(text):
    """The text without what is no code, line for line."""
    return NO_CODE.sub(lambda found: ('""' if found[0][0] in '"R' else "") + "\n" * found[0].count("\n"),
                       text)


def name_of(head):
    """The name of the function whose body comes behind `head`, None before any other brace."""
    test = TEST.search(head)
    if test:
        return f"{test[1]}.{test[2]}"
    before = head.split("(")[0]
    if "operator" not in before and re.search(r"(?<![=!<>])=(?!=)", before):  # a variable or a lambda
        return re.search(r"(\w+)\s*=", before)[1] if "](" in head or head.endswith("]") else None
    named = NAME.search(re.sub(ANGLES, "", ATTRIBUTE.sub("", head)))
    return re.sub(r"\s", "", named[1]) if named else None


def functions(text):
    """[(name, first line, last line)] of the functions with a body; those inside others belong to them.
    @raise ValueError  where braces do not match."""
    code = code_of(text)
    line, last, begin, found = 1, 0, 0, []
    braces, rounds = [], 0  # "scope", "inner", "member" or (name, line) of each open brace
    for mark in re.finditer(r"[{}();]", code):
        at, sign = mark.start(), mark[0]
        line, last = line + code.count("\n", last, at), at
        is_inside = bool(braces) and braces[-1] != "scope"
        if sign == "{":
            first = BEFORE.match(code, begin, at).end()
            head = code[first:at].strip()
            if is_inside or rounds:
                braces.append("inner")
            elif SCOPE.search(ATTRIBUTE.sub("", head)):
                braces.append("scope")
                begin = at + 1
            else:
                braces.append("member" if MEMBER.search(head) else
                              (name_of(head), line - code.count("\n", first, at)))
        elif sign == "}":
            if not braces:
                raise ValueError(f"line {line}: nothing is open here")
            closed = braces.pop()
            if isinstance(closed, tuple) and closed[0]:
                found.append((closed[0], closed[1], line))
            if closed == "scope" or isinstance(closed, tuple):
                begin = at + 1
        elif not is_inside:
            rounds += {"(": 1, ")": -1, ";": 0}[sign]
            if sign == ";" and not rounds:
                begin = at + 1
    if braces:
        raise ValueError("a brace is not closed")
    return found


def sources(folder):
    """Paths of all sources and scripts, relative to the folder, in order."""
    for root, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if name[0] not in "._" and name != "build")
        for name in sorted(names):
            if name.endswith(SOURCES + HEADERS + SCRIPTS):
                yield Path(root, name).relative_to(folder).as_posix()


def measured(folder, complain):
    """{path or path:function: (lines, limit)} of all that is beyond its limit."""
    beyond = {}

    def take(name, lines, limit):
        if lines >= limit:
            beyond[name] = max(beyond.get(name, (0, 0)), (lines, limit))

    for path in sources(folder):
        text = Path(folder, path).read_text()
        lines = text.split("\n")
        take(path, len(lines) - 1, HEADER if path.endswith(HEADERS) else FILE)
        if path.endswith(SCRIPTS):
            continue
        if lines[0] != "// SPDX-License-Identifier: Apache-2.0":
            complain(f"{path}: its first line is not the SPDX identifier")
        if path.endswith(HEADERS) and not lines[1].startswith("//"):
            complain(f"{path}: no comment says what the header is for")
        try:
            for name, first, last in functions(text):
                take(f"{path}:{name}", last - first + 1, FUNCTION)
                if last - first + 1 >= OUTLINE and not any(
                        line.lstrip().startswith("//") for line in lines[first:last]):
                    complain(f"{path}:{name}: {last - first + 1} lines without a comment that outlines them")
        except ValueError as error:
            complain(f"{path}: {error}")
    return beyond


def exceptions(path):
    """{path or path:function: lines} of lines "LINES NAME REASON"; # begins a comment."""
    allowed = {}
    for row in path.read_text().splitlines() if path.exists() else []:
        if row and not row.startswith("#"):
            lines, name, _ = row.split(None, 2)
            allowed[name] = int(lines)
    return allowed


def main(folder):
    complaints = []
    beyond = measured(folder, complaints.append)
    allowed = exceptions(Path(folder, "tests/limits.txt"))
    for name, (lines, limit) in sorted(beyond.items()):
        if lines > allowed.get(name, limit - 1):
            complaints.append(f"{name}: {lines} lines, {allowed.get(name, limit - 1)} are allowed")
    for name in sorted(allowed.keys() - beyond.keys()):
        complaints.append(f"{name}: needs no exception any more; take it out of tests/limits.txt")
    for complaint in complaints:
        print(complaint)
    print(f"limits: {len(complaints)} complaints, {len(allowed)} exceptions")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent))
