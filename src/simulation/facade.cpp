// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include <array>

#include "simulation/patterns.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr float kGroundFloor = 3.9F;  ///< m
constexpr float kFloor = 3.1F;        ///< m

struct Layout {
  int columns = 1, floors = 1;
  float pitch = 2.6F;
  float window_width = 1.2F, window_height = 1.6F;
};

Layout layoutOf(const Material& material, const FacePoint& p) {
  Layout layout;
  const float pitch = static_cast<float>(uniform(keyOf(material.seed, 1), 2.2, 3.1));
  layout.columns = std::max(1, static_cast<int>(p.width / pitch));
  layout.floors = std::max(0, static_cast<int>((p.height - kGroundFloor - 0.4F) / kFloor));
  layout.pitch = p.width / static_cast<float>(layout.columns);
  layout.window_width = std::min(layout.pitch - 0.7F, static_cast<float>(uniform(keyOf(material.seed, 2), 1.0, 1.6)));
  layout.window_height = static_cast<float>(uniform(keyOf(material.seed, 3), 1.4, 1.9));
  return layout;
}

Color brickWall(const Material& m, const FacePoint& p) {
  constexpr float kLength = 0.26F;
  constexpr float kHeight = 0.09F;
  const float course = std::floor(p.v / kHeight);
  const float shifted = p.u / kLength + (static_cast<int>(course) % 2 == 0 ? 0.F : 0.5F);
  const float brick = std::floor(shifted);
  const float tone = 2 * cellRandom(static_cast<int>(brick), static_cast<int>(course), m.seed) - 1;
  const float fade = clamp01(1.4F - p.footprint / kHeight);
  const Color face = m.color * (1 + 0.13F * tone * fade);
  const float mortar_u = 1 - inside(shifted - brick, 0.03F, 0.97F, std::max(0.01F, p.footprint / kLength));
  const float mortar_v = 1 - inside(p.v / kHeight - course, 0.08F, 0.92F, std::max(0.01F, p.footprint / kHeight));
  const float mortar = fade * std::max(mortar_u, mortar_v) + (1 - fade) * 0.2F;
  return blend(face, blend(m.color, Color(176, 168, 156), 0.65F), mortar);
}

Color blockWall(const Material& m, const FacePoint& p) {
  const float course = std::floor(p.v / 0.4F);
  const float shifted = p.u / 0.8F + (static_cast<int>(course) % 2 == 0 ? 0.F : 0.5F);
  const float block = std::floor(shifted);
  const float tone = 2 * cellRandom(static_cast<int>(block), static_cast<int>(course), m.seed) - 1;
  const float joint = 1 - inside((shifted - block) * 0.8F, 0.012F, 0.788F, p.footprint) *
                              inside(p.v - course * 0.4F, 0.012F, 0.388F, p.footprint);
  const float grain = fadedNoise(p.u, p.v, 0.11F, m.seed, p.footprint);
  return blend(m.color * (1 + 0.07F * tone + 0.04F * grain), m.color * 0.7F, joint);
}

Color plasterWall(const Material& m, const FacePoint& p) {
  const float stains = fadedNoise(p.u, 0.4F * p.v, 1.3F, m.seed, p.footprint);
  const float grain = fadedNoise(p.u, p.v, 0.17F, m.seed + 1, p.footprint);
  return m.color * (1 + 0.06F * stains + 0.03F * grain);
}

/// A painted wall: colours that flow into each other, where seams between images show.
Color muralWall(const Material& m, const FacePoint& p) {
  const float wave = 0.5F + 0.5F * std::sin(0.55F * p.u + 1.7F * std::sin(0.4F * p.v + static_cast<float>(m.seed % 7)));
  return blend(m.color, m.accent, 0.75F * wave + 0.25F * clamp01(p.v / p.height));
}

Color wall(const Material& m, const FacePoint& p) {
  switch (m.seed % 8) {
    case 0:
    case 1:
    case 4:
      return brickWall(m, p);
    case 2:
      return blockWall(m, p);
    case 3:
      return muralWall(m, p);
    default:
      return plasterWall(m, p);
  }
}

Color glass(float u, float v, float height, std::uint32_t key) {
  const float sky = clamp01(v / height + 0.25F * (u - 0.4F));
  Color color = blend(Color(38, 46, 58), Color(126, 150, 172), 0.8F * sky);
  const float curtain = static_cast<float>(uniform(keyOf(key, 5)));
  if (curtain > 0.45F && v > height * curtain) color = blend(color, Color(214, 206, 190), 0.75F);
  return color;
}

/// A window whose lower left corner is the origin, with frame, bars, sill and lintel.
Color window(const Color& wall_color, const Material& m, const Layout& l, float u, float v, std::uint32_t key,
             float fp) {
  constexpr float kFrame = 0.08F;
  const float w = l.window_width;
  const float h = l.window_height;
  Color color = wall_color;
  color = blend(color, m.accent, insideRect(u, v, -0.14F, -0.14F, w + 0.14F, 0, fp));
  color = blend(color, m.accent * 0.92F, insideRect(u, v, -0.1F, h, w + 0.1F, h + 0.18F, fp));
  color = blend(color, Color(206, 204, 198), insideRect(u, v, 0, 0, w, h, fp));
  const float pane = insideRect(u, v, kFrame, kFrame, w - kFrame, h - kFrame, fp) *
                     (1 - inside(u, w / 2 - 0.035F, w / 2 + 0.035F, fp)) *
                     (1 - inside(v, 0.62F * h, 0.62F * h + 0.06F, fp));
  return blend(color, glass(u, v, h, key), pane);
}

Color door(const Color& wall_color, float u, float v, std::uint32_t key, float fp) {
  static const std::array<Color, 5> kPaints = {Color(112, 62, 34), Color(38, 84, 62), Color(132, 36, 38),
                                               Color(40, 66, 118), Color(70, 58, 52)};
  const Color paint = kPaints[key % kPaints.size()];
  Color color = blend(wall_color, Color(206, 200, 188), insideRect(u, v, -0.14F, 0, 1.24F, 2.64F, fp));
  color = blend(color, paint, insideRect(u, v, 0, 0, 1.1F, 2.15F, fp));
  color = blend(color, Color(96, 122, 142), insideRect(u, v, 0, 2.2F, 1.1F, 2.52F, fp));
  for (int panel = 0; panel < 4; ++panel) {
    const float u0 = panel % 2 == 0 ? 0.12F : 0.6F;
    const float v0 = panel < 2 ? 0.2F : 1.15F;
    color = blend(color, paint * 0.68F, insideRect(u, v, u0, v0, u0 + 0.38F, v0 + 0.8F, fp));
  }
  return blend(color, Color(216, 186, 92), insideRect(u, v, 0.98F, 0.98F, 1.05F, 1.12F, fp));
}

/// Goods behind a shop window: boxes of many colours on shelves.
Color display(float u, float v, std::uint32_t key, float fp) {
  const float shelf = std::floor(v / 0.55F);
  const float item = std::floor(u / 0.34F);
  const float tall = 0.2F + 0.28F * cellRandom(static_cast<int>(item), static_cast<int>(shelf), key);
  const float hue = 6.28F * cellRandom(static_cast<int>(item), static_cast<int>(shelf), key + 1);
  const Color goods(128 + 92 * std::sin(hue), 124 + 84 * std::sin(hue + 2.1F), 120 + 88 * std::sin(hue + 4.2F));
  const float share = insideRect(u - item * 0.34F, v - shelf * 0.55F, 0.04F, 0.04F, 0.3F, tall, fp);
  Color color = blend(Color(58, 56, 60), Color(150, 140, 116), clamp01(v / 3));
  color = blend(color, goods, share);
  return blend(color, Color(186, 180, 168), inside(v - shelf * 0.55F, 0, 0.035F, fp));
}

Color shopSign(const Color& under, const FacePoint& p, std::uint32_t key) {
  static const std::array<const char*, 12> kWords = {"BAKERY", "BOOKS", "CAFE",  "HOTEL",    "CINEMA", "FLOWERS",
                                                     "BIKES",  "PIZZA", "MUSIC", "PHARMACY", "OPTIK",  "MUSEUM"};
  static const std::array<Color, 6> kPlates = {Color(176, 34, 38), Color(28, 74, 138),   Color(232, 196, 64),
                                               Color(30, 110, 72), Color(208, 204, 194), Color(52, 46, 54)};
  const char* word = kWords[key % kWords.size()];
  const Color plate = kPlates[(key / 16) % kPlates.size()];
  const Color ink = plate.mean() > 140 ? Color(36, 32, 40) : Color(212, 208, 194);
  const float letters = std::min(0.52F, (p.width - 1) / (letteringWidth(word, 1) + 0.3F));
  const float text = letteringWidth(word, letters);
  const float half = text / 2 + 0.35F;
  const float u = p.u - p.width / 2;
  const float v = p.v - 3.0F;
  Color color = blend(under, plate * 0.7F, insideRect(u, v, -half - 0.06F, -0.06F, half + 0.06F, 0.86F, p.footprint));
  color = blend(color, plate, insideRect(u, v, -half, 0, half, 0.8F, p.footprint));
  if (v < 0 || v > 0.8F) return color;
  return blend(color, ink, letteringInk(word, u + text / 2, v - (0.8F - letters) / 2, letters, p.footprint));
}

Color shopFloor(const Color& under, const Material& m, const Layout& l, const FacePoint& p) {
  const int column = std::min(l.columns - 1, static_cast<int>(p.u / l.pitch));
  const float u = p.u - static_cast<float>(column) * l.pitch;
  Color color = under;
  if (column == static_cast<int>(m.seed / 3 % static_cast<unsigned>(l.columns))) {
    color = door(color, u - (l.pitch - 1.1F) / 2, p.v, m.seed / 5, p.footprint);
  } else {
    const float frame = insideRect(u, p.v, 0.15F, 0.45F, l.pitch - 0.15F, 2.7F, p.footprint);
    color = blend(color, Color(64, 62, 66), frame);
    const float pane = insideRect(u, p.v, 0.24F, 0.54F, l.pitch - 0.24F, 2.61F, p.footprint);
    if (pane > 0) color = blend(color, display(u, p.v, keyOf(m.seed, column) & 0xFFFFU, p.footprint), pane);
  }
  return shopSign(color, p, m.seed / 7);
}

Color houseFloor(const Color& under, const Material& m, const Layout& l, const FacePoint& p) {
  const int column = std::min(l.columns - 1, static_cast<int>(p.u / l.pitch));
  const float u = p.u - static_cast<float>(column) * l.pitch;
  const auto key = static_cast<std::uint32_t>(keyOf(m.seed, column));
  const bool is_front = std::abs(p.normal.y()) > 0.7F;
  if (is_front && column == static_cast<int>(m.seed / 3 % static_cast<unsigned>(l.columns))) {
    return door(under, u - (l.pitch - 1.1F) / 2, p.v, key, p.footprint);
  }
  return window(under, m, l, u - (l.pitch - l.window_width) / 2, p.v - 1.1F, key, p.footprint);
}

}  // namespace

Color facadeAlbedo(const Material& m, const FacePoint& p) {
  if (std::abs(p.normal.z()) > 0.7F)
    return Color(118, 112, 108) * (1 + 0.1F * fadedNoise(p.u, p.v, 0.5F, 3, p.footprint));
  const Layout l = layoutOf(m, p);
  Color color = wall(m, p);
  // Splash water darkens the foot of every wall, and the eaves keep its top clean.
  color *= 0.8F + 0.2F * clamp01(p.v / 1.5F + 0.25F * fadedNoise(p.u, p.v, 0.6F, m.seed, p.footprint));
  color = blend(color, Color(104, 100, 98), inside(p.v, -1, 0.35F, p.footprint));
  const bool is_shop = std::abs(p.normal.y()) > 0.7F && m.seed / 11 % 5 < 3 && p.width > 4;
  const int floor = p.v < kGroundFloor ? -1 : static_cast<int>((p.v - kGroundFloor) / kFloor);
  if (floor < 0) {
    color = is_shop ? shopFloor(color, m, l, p) : houseFloor(color, m, l, p);
  } else if (floor < l.floors) {
    const int column = std::min(l.columns - 1, static_cast<int>(p.u / l.pitch));
    const float u = p.u - static_cast<float>(column) * l.pitch - (l.pitch - l.window_width) / 2;
    const float v = p.v - kGroundFloor - static_cast<float>(floor) * kFloor - 0.75F;
    color = window(color, m, l, u, v, static_cast<std::uint32_t>(keyOf(m.seed, column, floor)), p.footprint);
  }
  color = blend(color, m.accent * 0.95F, inside(p.v, kGroundFloor - 0.12F, kGroundFloor + 0.1F, p.footprint));
  return blend(color, m.accent, inside(p.v, p.height - 0.35F, p.height + 1, p.footprint));
}

}  // namespace cloud_colorizer::simulation
