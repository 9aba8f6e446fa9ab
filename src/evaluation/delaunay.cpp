// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/base/check.hpp"
#include "evaluation/neighbors.hpp"

#ifdef CLOUD_COLORIZER_CGAL
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <utility>
#endif

namespace cloud_colorizer {

#ifdef CLOUD_COLORIZER_CGAL

bool hasDelaunay() {
  return true;
}

std::vector<Edge> delaunayGraph(PointsRef points) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Vertex = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
  using Cell = CGAL::Delaunay_triangulation_cell_base_3<Kernel>;
  using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex, Cell>>;
  std::vector<std::pair<Kernel::Point_3, std::uint32_t>> vertices;
  vertices.reserve(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    vertices.emplace_back(Kernel::Point_3(points(0, p), points(1, p), points(2, p)), static_cast<std::uint32_t>(p));
  }
  const Triangulation triangulation(vertices.begin(), vertices.end());
  std::vector<Edge> edges;
  for (auto edge = triangulation.finite_edges_begin(); edge != triangulation.finite_edges_end(); ++edge) {
    const std::uint32_t a = edge->first->vertex(edge->second)->info(), b = edge->first->vertex(edge->third)->info();
    edges.push_back({std::min(a, b), std::max(a, b), 1});
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return std::pair(a.p, a.q) < std::pair(b.p, b.q); });
  return edges;
}

#else

bool hasDelaunay() {
  return false;
}

std::vector<Edge> delaunayGraph(PointsRef) {
  require(false, "built without CGAL (Debian: libcgal-dev), so there is no Delaunay graph");
  return {};
}

#endif

}  // namespace cloud_colorizer
