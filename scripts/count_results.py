#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
"""Counts the test cases in a folder of JUnit files: prints "passed failed", and the failed ones on stderr."""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def main(folder):
    passed, failed = 0, 0
    for path in sorted(pathlib.Path(folder).rglob("*.xml")):
        try:
            cases = list(ElementTree.parse(path).getroot().iter("testcase"))
        except ElementTree.ParseError as error:
            print(f"FAILED  {path}: {error}", file=sys.stderr)
            failed += 1
            continue
        for case in cases:
            problems = case.findall("failure") + case.findall("error")
            if problems:
                print(f"FAILED  {path.stem}: {case.get('classname')}.{case.get('name')}", file=sys.stderr)
                for problem in problems:
                    print(problem.get("message", "").rstrip(), file=sys.stderr)
                failed += 1
            elif case.find("skipped") is None and case.get("status") != "notrun":
                passed += 1
    print(passed, failed)


main(sys.argv[1])
