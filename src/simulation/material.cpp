// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/patterns.hpp"

namespace cloud_colorizer::simulation {
namespace {

float modulo(float x, float period) {
  return x - period * std::floor(x / period);
}

Color asphalt(const Material& m, const FacePoint& p) {
  const float x = p.local.x();
  const float y = p.local.y();
  const float fp = p.footprint;
  float tone = 1 + 0.07F * fadedNoise(x, y, 2.7F, m.seed, fp) + 0.05F * fadedNoise(x, y, 0.45F, m.seed + 1, fp) +
               0.05F * fadedNoise(x, y, 0.09F, m.seed + 2, fp);
  // Wheels polish two tracks in each lane.
  const float in_lane = std::abs(std::abs(y) - 1.5F);
  tone += 0.07F * clamp01(1 - std::abs(in_lane - 0.75F) / 0.35F);
  Color color = Color(116, 114, 114) * tone;
  // Repaired patches.
  const float cell = std::floor(x / 9);
  const float px = x - 9 * cell - 5 * cellRandom(static_cast<int>(cell), 1, m.seed);
  const float py = y - (cellRandom(static_cast<int>(cell), 2, m.seed) * 6 - 4);
  color = blend(color, Color(92, 92, 95) * tone, insideRect(px, py, 0, 0, 2.6F, 1.2F, fp));
  // Cracks along the zero line of a noise, in some places only.
  const float crack = std::abs(fadedNoise(x, y, 0.8F, m.seed + 7, fp));
  const float place = clamp01(3 * fadedNoise(x, y, 3.1F, m.seed + 8, fp) - 0.6F);
  return color * (1 - 0.35F * place * clamp01(1 - crack / 0.05F));
}

Color manhole(const Color& under, const FacePoint& p, std::uint32_t seed) {
  const float cell = std::floor(p.local.x() / 13);
  const float x = p.local.x() - 13 * cell - 3 - 6 * cellRandom(static_cast<int>(cell), 3, seed);
  const float y = p.local.y() - (static_cast<int>(cell) % 2 == 0 ? 0.9F : -2.1F);
  const float radius = std::hypot(x, y);
  Color color = blend(under, Color(58, 54, 52), 1 - above(radius, 0.36F, p.footprint));
  const float ribs = inside(modulo(x, 0.09F), 0.03F, 0.06F, std::max(p.footprint, 0.005F));
  return blend(color, Color(98, 92, 86), (1 - above(radius, 0.31F, p.footprint)) * ribs);
}

float markings(const FacePoint& p) {
  const float x = p.local.x();
  const float y = p.local.y();
  const float fp = p.footprint;
  float paint = inside(y, -0.07F, 0.07F, fp) * inside(modulo(x, 6), 0, 3, fp);
  paint = std::max(paint, inside(std::abs(y), kLaneHalfWidth - 0.06F, kLaneHalfWidth + 0.06F, fp));
  // Parking bays.
  const float bay =
      inside(std::abs(y), kLaneHalfWidth, kRoadHalfWidth - 0.1F, fp) * inside(modulo(x, 5.6F), 0, 0.1F, fp);
  paint = std::max(paint, bay);
  // A zebra crossing every 48 m.
  const float zebra = inside(modulo(x - 26, 48), 0, 3, fp) * inside(modulo(y, 1), 0.25F, 0.75F, fp);
  paint = std::max(paint, zebra * inside(std::abs(y), -1, kRoadHalfWidth - 0.2F, fp));
  // Words for the driver of each lane, read along his way.
  const float along = modulo(x - 11, 32);
  if (std::abs(y) < kLaneHalfWidth && along < 2.4F) {
    const float side = y < 0 ? 1.F : -1.F;
    const float u = -side * (y + side * 1.5F) + letteringWidth("SLOW", 0.68F) / 2;
    const float v = (side > 0 ? along : 2.4F - along) / 3.5F;
    paint = std::max(paint, letteringInk("SLOW", u, v, 0.68F, fp));
  }
  const float wear = 0.86F + 0.14F * fadedNoise(x, y, 0.14F, 77, fp);
  return paint * wear;
}

Color yard(const FacePoint& p) {
  const float x = p.local.x();
  const float y = p.local.y();
  const float meadow = valueNoise(x / 4, y / 4, 5);
  const Color gravel = Color(150, 138, 118) * (1 + 0.1F * fadedNoise(x, y, 0.12F, 8, p.footprint));
  const Color grass = Color(92, 122, 62) * (1 + 0.22F * fadedNoise(x, y, 0.16F, 9, p.footprint));
  return blend(gravel, grass, clamp01((meadow - 0.4F) * 6));
}

Color paving(const Material& m, const FacePoint& p) {
  constexpr float kSlab = 0.5F;
  const float row = std::floor(p.local.y() / kSlab);
  const float shifted = p.local.x() / kSlab + (static_cast<int>(row) % 2 == 0 ? 0.F : 0.5F);
  const float column = std::floor(shifted);
  const float tone = 2 * cellRandom(static_cast<int>(column), static_cast<int>(row), m.seed) - 1;
  const float joint = 1 - inside((shifted - column) * kSlab, 0.012F, kSlab - 0.012F, p.footprint) *
                              inside(p.local.y() - row * kSlab, 0.012F, kSlab - 0.012F, p.footprint);
  const float grain = fadedNoise(p.local.x(), p.local.y(), 0.13F, m.seed, p.footprint);
  return blend(m.color * (1 + 0.09F * tone + 0.04F * grain), m.color * 0.62F, joint);
}

Color kerb(const Material& m, const FacePoint& p) {
  const float stone = std::floor(p.local.x());
  const float tone = 2 * cellRandom(static_cast<int>(stone), 4, m.seed) - 1;
  const float joint = 1 - inside(p.local.x() - stone, 0.01F, 0.99F, p.footprint);
  return blend(m.color * (1 + 0.06F * tone), m.color * 0.6F, joint);
}

Color carBody(const Material& m, const FacePoint& p) {
  const float x = p.local.x();
  const float z = p.local.z();
  const float fp = p.footprint;
  Color color = m.color * (0.86F + 0.2F * clamp01(z + 0.5F));
  if (std::abs(p.normal.y()) > 0.7F) {
    color = blend(color, m.color * 0.45F, inside(std::abs(x - 0.05F), 0.98F, 1.0F, fp) + inside(x, 0.0F, 0.02F, fp));
    color = blend(color, Color(200, 200, 204), insideRect(std::abs(x - 0.45F), z, 0.28F, 0.14F, 0.44F, 0.18F, fp));
    return blend(color, Color(38, 38, 42), inside(z, -1, -0.22F, fp));
  }
  if (std::abs(p.normal.x()) < 0.5F) return color;
  const float y = p.local.y();
  const bool is_front = p.normal.x() > 0;
  color = blend(color, is_front ? Color(236, 236, 226) : Color(178, 26, 26),
                insideRect(std::abs(y), z, 0.5F, -0.02F, 0.8F, 0.14F, fp));
  color = blend(color, Color(36, 36, 40), insideRect(std::abs(y), z, -1, -0.3F, 0.62F, -0.12F, fp));
  if (!is_front) color = blend(color, Color(230, 228, 210), insideRect(std::abs(y), z, -1, -0.1F, 0.27F, 0.02F, fp));
  return color;
}

/// Glass all around, pillars and roof in the car's paint.
Color carCabin(const Material& m, const FacePoint& p) {
  if (p.normal.z() > 0.95F || std::abs(p.normal.x()) + std::abs(p.normal.y()) < 0.5F) return m.color;
  const float fp = p.footprint;
  const Color pane = blend(Color(34, 40, 48), Color(124, 142, 158), clamp01(p.local.z() / 0.7F));
  if (std::abs(p.normal.y()) > 0.7F) {
    const float lean = 0.62F * p.v;
    float share = inside(p.v, 0.05F, p.height - 0.09F, fp) * inside(p.u, 0.14F + lean, p.width - 0.14F - lean, fp);
    share *= 1 - inside(p.u, 0.5F * p.width - 0.04F, 0.5F * p.width + 0.04F, fp);
    return blend(m.color, pane, share);
  }
  return blend(m.color, pane, insideRect(p.local.y(), p.local.z(), -0.68F, 0.04F, 0.68F, 0.49F, fp));
}

Color wheel(const FacePoint& p) {
  const float radius = std::hypot(p.local.x(), p.local.y());
  if (std::abs(p.normal.z()) < 0.7F) return Color(34, 33, 34);
  const float spokes = std::cos(5 * std::atan2(p.local.y(), p.local.x())) > -0.2F ? 1.F : 0.55F;
  return blend(Color(34, 33, 34), Color(168, 170, 174) * spokes, 1 - above(radius, 0.21F, p.footprint));
}

/// A round plate (frame: axis z of its cylinder): ring and bar.
Color sign(const Material& m, const FacePoint& p) {
  if (p.normal.z() < 0.7F) return Color(128, 130, 134);
  const float radius = std::hypot(p.local.x(), p.local.y());
  if (m.seed % 2 == 0) {
    const float bar = insideRect(std::abs(p.local.x()), std::abs(p.local.y()), -1, -1, 0.22F, 0.055F, p.footprint);
    return blend(m.color, Color(238, 238, 234), bar);
  }
  return blend(Color(238, 238, 234), m.color, above(radius, 0.23F, p.footprint));
}

Color leaves(const Material& m, const FacePoint& p) {
  // Noise over all three planes: no seam, no pole.
  const auto noise = [&](float feature, std::uint32_t seed) {
    return fadedNoise(p.local.x(), p.local.y(), feature, seed, p.footprint) +
           fadedNoise(p.local.y(), p.local.z(), feature, seed + 1, p.footprint) +
           fadedNoise(p.local.z(), p.local.x(), feature, seed + 2, p.footprint);
  };
  return m.color * (1 + 0.2F * noise(0.31F, m.seed) + 0.2F * noise(0.1F, m.seed + 3));
}

Color bands(const Material& m, const FacePoint& p) {
  return blend(m.color, m.accent, inside(modulo(p.u + p.v, 0.5F), 0.25F, 0.5F, p.footprint));
}

}  // namespace

Color groundAlbedo(const Material& m, const FacePoint& p) {
  if (std::abs(p.local.y()) > kRoadHalfWidth + 0.5F) return yard(p);
  return blend(manhole(asphalt(m, p), p, m.seed), Color(206, 204, 196), markings(p));
}

Color albedo(const Material& m, const FacePoint& p) {
  switch (m.pattern) {
    case Pattern::kPlain:
      return m.color;
    case Pattern::kGround:
      return groundAlbedo(m, p);
    case Pattern::kPaving:
      return paving(m, p);
    case Pattern::kKerb:
      return kerb(m, p);
    case Pattern::kFacade:
      return facadeAlbedo(m, p);
    case Pattern::kRoof:
      return m.color * (1 + 0.12F * fadedNoise(p.u, p.v, 0.3F, m.seed, p.footprint));
    case Pattern::kCarBody:
      return carBody(m, p);
    case Pattern::kCarCabin:
      return carCabin(m, p);
    case Pattern::kWheel:
      return wheel(p);
    case Pattern::kBark:
      return m.color * (1 + 0.2F * fadedNoise(6 * p.u, p.v, 0.3F, m.seed, p.footprint));
    case Pattern::kLeaves:
      return leaves(m, p);
    case Pattern::kSign:
      return sign(m, p);
    case Pattern::kBands:
      return bands(m, p);
  }
  return m.color;
}

}  // namespace cloud_colorizer::simulation
