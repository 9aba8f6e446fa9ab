// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/crs.hpp"

#include <proj.h>

#include <memory>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

std::string wellKnownText(const std::string& crs) {
  using Invalid = std::invalid_argument;
  const std::unique_ptr<PJ_CONTEXT, decltype(&proj_context_destroy)> context(proj_context_create(),
                                                                             proj_context_destroy);
  proj_log_level(context.get(), PJ_LOG_NONE);
  const std::unique_ptr<PJ, decltype(&proj_destroy)> system(proj_create(context.get(), crs.c_str()), proj_destroy);
  require<Invalid>(
      system && proj_is_crs(system.get()) != 0, "\"", crs,
      "\" is no coordinate reference system that PROJ knows; give a code such as EPSG:25832, or well-known "
      "text");
  const char* const options[] = {"MULTILINE=NO", nullptr};
  const char* text = proj_as_wkt(context.get(), system.get(), PJ_WKT1_GDAL, options);
  require<Invalid>(text != nullptr, "\"", crs, "\" cannot be told as well-known text of version 1, which LAS needs");
  return text;
}

}  // namespace cloud_colorizer
