// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cloud_colorizer {

/// src/report/page.html, with @FACTS@ and @POINTS@ where those belong.
extern const char* const kPage;

}  // namespace cloud_colorizer
