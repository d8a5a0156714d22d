#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lists what was skipped, and why, in ctest's JUnit reports.

    scripts/skipped_tests.py REPORT.xml...

A unit test prints `skip NAME: REASON`, a command-line test `skipped: REASON`, also for a part of it. Exit status 1 if a
reason is that a package or program "is not installed" (scripts/setup --all), or if a test gives no reason.
"""
import collections
import pathlib
import re
import sys
import xml.etree.ElementTree

REASON = re.compile(r"^(?:skip \w+|skipped): (.*)$", re.M)


def reasons_of(case):
    found = REASON.findall(case.findtext("system-out") or "")
    if not found and case.find("skipped") is not None and case.get("status") == "notrun":
        found = ["no reason is given"]
    return found


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    tests = collections.defaultdict(set)
    for report in sys.argv[1:]:
        for case in xml.etree.ElementTree.parse(report).getroot().iter("testcase"):
            for reason in reasons_of(case):
                tests[reason].add(f"{case.get('name')} ({pathlib.Path(report).stem})")
    for reason in sorted(tests):
        print(f"skipped: {reason}: {', '.join(sorted(tests[reason]))}")
    bad = [reason for reason in tests if "is not installed" in reason or reason == "no reason is given"]
    sys.exit(1 if bad else 0)


main()
