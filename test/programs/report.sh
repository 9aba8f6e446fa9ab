#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# scripts/report.py: the tables of `evaluate` as Markdown, plots and bars, each part on a table made by hand.
cd "$(dirname "$0")" && exec /usr/bin/python3 report_test.py
