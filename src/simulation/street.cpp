// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/street.hpp"

#include <array>
#include <cmath>

#include "cloud_colorizer/base/check.hpp"
#include "simulation/random.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr double kPi = 3.14159265358979;
constexpr double kKerbHeight = 0.12;     // m
constexpr double kPavementEnd = 7.8;     // m from the middle of the road
constexpr double kGroundHalfWidth = 45;  // m
constexpr double kRoad = static_cast<double>(kRoadHalfWidth);

Primitive boxBetween(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Material& material, int object) {
  const Eigen::Vector3d half = (high - low) / 2;
  Primitive p;
  p.profile = {{-half.x(), -half.z()}, {half.x(), -half.z()}, {half.x(), half.z()}, {-half.x(), half.z()}};
  p.half_length = half.y();
  p.map_from_local.translation() = (low + high) / 2;
  p.material = material;
  p.object = object;
  return p;
}

Primitive uprightCylinder(const Eigen::Vector3d& foot, double radius, double height, const Material& material,
                          int object) {
  Primitive p;
  p.shape = Shape::kCylinder;
  p.radius = radius;
  p.half_length = height / 2;
  p.map_from_local.translation() = foot + Eigen::Vector3d(0, 0, height / 2);
  p.material = material;
  p.object = object;
  return p;
}

Material materialOf(Pattern pattern, const Color& color, std::uint64_t seed = 0, float reflectivity = 0.4F) {
  Material m;
  m.pattern = pattern;
  m.color = color;
  m.seed = static_cast<std::uint32_t>(seed & 0x7FFFFFFFU);
  m.reflectivity = reflectivity;
  return m;
}

template <std::size_t N>
const Color& pick(const std::array<Color, N>& colors, std::uint64_t key) {
  return colors[mixBits(key) % N];
}

constexpr std::uint64_t kVan = 990002;

std::shared_ptr<const Motion> steady(const Eigen::Vector3d& velocity) {
  return std::make_shared<const Motion>(Motion{{{0, Eigen::Vector3d::Zero()}, {1, velocity}}});
}

/// Adds parts to the list; every call of next() begins a new object.
class StreetBuilder {
 public:
  explicit StreetBuilder(const StreetOptions& options) : options_(options) {}

  std::vector<Primitive> build() {
    addGround();
    addHouses(1);
    addHouses(-1);
    addEnds();
    for (const int side : {1, -1}) {
      addParkedCars(side);
      addLamps(side);
      addTreesAndSigns(side);
    }
    if (options_.moving_car) {
      addCar({options_.car_start, 1.55, 0}, kPi, 990001, steady({options_.car_speed, 0, 0}));
    }
    if (options_.van) addCar({0, -1.5, 0}, 0, kVan, options_.van);
    for (int i = 0; i < options_.pedestrians; ++i) addPedestrian(i);
    return std::move(parts_);
  }

 private:
  template <class... Integers>
  std::uint64_t key(Integers... integers) const {
    return keyOf(options_.seed, integers...);
  }
  void add(Primitive part) { parts_.push_back(std::move(part)); }
  void addBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Material& material) {
    add(boxBetween(low, high, material, object_));
  }
  void next() { ++object_; }

  void addGround();
  void addHouses(int side);
  void addHouse(int side, double x0, double x1, std::uint64_t house);
  void addHouseDetails(int side, double x0, double x1, double front, double height, const Material& wall);
  void addEnds();
  void addParkedCars(int side);
  void addCar(const Eigen::Vector3d& foot, double yaw, std::uint64_t car, const std::shared_ptr<const Motion>& motion);
  void addPedestrian(int number);
  void addLamps(int side);
  void addTreesAndSigns(int side);
  void addTree(const Eigen::Vector3d& foot, std::uint64_t tree);
  void addSign(const Eigen::Vector3d& foot, std::uint64_t sign);

  StreetOptions options_;
  std::vector<Primitive> parts_;
  int object_ = 0;
};

void StreetBuilder::addGround() {
  const double x0 = options_.from - 20;
  const double x1 = options_.to + 20;
  Primitive ground = boxBetween({-1, -kGroundHalfWidth, -2}, {1, kGroundHalfWidth, 0},
                                materialOf(Pattern::kGround, Color(92, 92, 94), key(1), 0.25F), object_);
  // Its local x and y are those of the map, so that the markings stand still when the street grows.
  ground.profile = {{x0, -1}, {x1, -1}, {x1, 1}, {x0, 1}};
  add(ground);
  for (const int side : {1, -1}) {
    next();
    const double kerb_end = kRoad + 0.18;
    const auto slab = [&](double a, double b, const Material& material, double top) {
      const double low = std::min(side * a, side * b);
      const double high = std::max(side * a, side * b);
      addBox({x0 + 2, low, -0.5}, {x1 - 2, high, top}, material);
    };
    slab(kRoad, kerb_end, materialOf(Pattern::kKerb, Color(178, 174, 166), key(2), 0.5F), kKerbHeight);
    slab(kerb_end, kPavementEnd, materialOf(Pattern::kPaving, Color(158, 150, 140), key(3), 0.4F), kKerbHeight - 0.005);
  }
}

void StreetBuilder::addHouses(int side) {
  double x = options_.from;
  for (int i = 0; x < options_.to - 5; ++i) {
    const std::uint64_t house = key(10, side, i);
    const double width = std::min(uniform(keyOf(house, 1), 7, 14), options_.to - x);
    addHouse(side, x, x + width, house);
    const bool has_alley = uniform(keyOf(house, 2)) < 0.45;
    x += width + (has_alley ? uniform(keyOf(house, 3), 1.6, 4.2) : 0.0);
  }
}

void StreetBuilder::addHouse(int side, double x0, double x1, std::uint64_t house) {
  static const std::array<Color, 10> kWalls = {
      Color(168, 92, 70), Color(206, 186, 150), Color(186, 120, 88),  Color(150, 164, 176), Color(208, 190, 118),
      Color(142, 72, 58), Color(176, 196, 168), Color(200, 196, 188), Color(204, 150, 118), Color(158, 138, 150)};
  static const std::array<Color, 4> kTrims = {Color(214, 208, 194), Color(190, 180, 164), Color(206, 202, 194),
                                              Color(150, 142, 134)};
  next();
  Material wall = materialOf(Pattern::kFacade, pick(kWalls, keyOf(house, 4)), keyOf(house, 5), 0.45F);
  if (wall.seed % 8 == 0 || wall.seed % 8 == 1 || wall.seed % 8 == 4) {
    static const std::array<Color, 4> kBricks = {Color(164, 86, 64), Color(186, 126, 92), Color(140, 74, 62),
                                                 Color(196, 160, 118)};
    wall.color = pick(kBricks, keyOf(house, 6));
  }
  wall.accent = wall.seed % 8 == 3 ? Color(96, 148, 196) : pick(kTrims, keyOf(house, 7));
  const double front = kPavementEnd + (uniform(keyOf(house, 8)) < 0.35 ? uniform(keyOf(house, 9), 0.3, 1.2) : 0.0);
  const double height = 3.9 + 3.1 * (1 + static_cast<int>(uniform(keyOf(house, 10), 0, 3))) + 0.6;
  const double depth = uniform(keyOf(house, 11), 8, 12);
  const double y0 = std::min(side * front, side * (front + depth));
  const double y1 = std::max(side * front, side * (front + depth));
  // The walls begin at the ground, so that v of the facade is the height.
  addBox({x0, y0, 0}, {x1, y1, height}, wall);
  addHouseDetails(side, x0, x1, front, height, wall);
}

void StreetBuilder::addHouseDetails(int side, double x0, double x1, double front, double height, const Material& wall) {
  const auto from_front = [&](double x_low, double x_high, double out, double in, double z0, double z1,
                              const Material& m) {
    const double a = side * (front - out);
    const double b = side * (front + in);
    addBox({x_low, std::min(a, b), z0}, {x_high, std::max(a, b), z1}, m);
  };
  const Material trim = materialOf(Pattern::kPlain, wall.accent, 0, 0.5F);
  from_front(x0, x1, 0.22, 0.1, height - 0.3, height + 0.12, trim);
  // Downpipe.
  add(uprightCylinder({x0 + 0.12, side * (front - 0.07), 0.1}, 0.05, height - 0.5,
                      materialOf(Pattern::kPlain, Color(112, 116, 112), 0, 0.3F), object_));
  // A step before the door would stand in the way of its pattern; planters do not.
  if (wall.seed % 3 == 0) {
    from_front(x1 - 1.7, x1 - 0.6, 0.5, 0.0, kKerbHeight - 0.02, 0.6, materialOf(Pattern::kPlain, Color(126, 96, 76)));
    from_front(x1 - 1.62, x1 - 0.68, 0.42, -0.08, 0.55, 1.0,
               materialOf(Pattern::kLeaves, Color(82, 120, 58), wall.seed, 0.6F));
  }
  const double middle = (x0 + x1) / 2;
  if (wall.seed % 5 == 1 || wall.seed % 5 == 3) {  // awning
    Material stripes = materialOf(Pattern::kBands, Color(196, 62, 54), 0, 0.4F);
    stripes.accent = Color(228, 222, 208);
    from_front(middle - 2, middle + 2, 0.9, 0.05, 2.78, 2.9, stripes);
  }
  if (wall.seed % 4 == 2) {  // balcony
    from_front(middle - 1.6, middle + 1.6, 0.95, 0.1, 4.35, 4.5, trim);
    from_front(middle - 1.6, middle + 1.6, 0.95, -0.88, 4.5, 5.3, materialOf(Pattern::kPlain, Color(86, 92, 96)));
  }
}

void StreetBuilder::addEnds() {
  for (const double x : {options_.from - 14, options_.to + 14}) {
    next();
    Material wall = materialOf(Pattern::kFacade, Color(196, 176, 148), x < 0 ? 5 : 8 * 61, 0.45F);
    wall.accent = Color(214, 208, 194);
    addBox({x - 4, -18, 0}, {x + 4, 18, 13}, wall);
  }
}

void StreetBuilder::addParkedCars(int side) {
  for (int i = 0;; ++i) {
    const double x = std::ceil(options_.from / 5.6) * 5.6 + 2.8 + 5.6 * i;
    if (x > options_.to - 4) break;
    const std::uint64_t car = key(20, side, i);
    if (uniform(keyOf(car, 1)) < 0.5) continue;
    const double y = side * (4.05 + uniform(keyOf(car, 2), -0.12, 0.12));
    const double yaw = (side > 0 ? kPi : 0) + uniform(keyOf(car, 3), -0.04, 0.04);
    addCar({x + uniform(keyOf(car, 4), -0.3, 0.3), y, 0}, yaw, car, nullptr);
  }
}

void StreetBuilder::addCar(const Eigen::Vector3d& foot, double yaw, std::uint64_t car,
                           const std::shared_ptr<const Motion>& motion) {
  static const std::array<Color, 9> kPaints = {Color(176, 30, 34),   Color(34, 66, 128),  Color(190, 190, 194),
                                               Color(58, 60, 66),    Color(226, 186, 58), Color(44, 104, 84),
                                               Color(150, 156, 164), Color(214, 118, 48), Color(200, 198, 192)};
  next();
  const Eigen::Isometry3d map_from_car = Eigen::Translation3d(foot) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
  const bool is_van = car == kVan || uniform(keyOf(car, 5)) < 0.2;
  const Color paint = pick(kPaints, keyOf(car, 6));
  const auto addPart = [&](std::vector<Eigen::Vector2d> profile, double half_width, double z, Pattern pattern) {
    Primitive p;
    p.profile = std::move(profile);
    p.half_length = half_width;
    p.map_from_local = map_from_car * Eigen::Translation3d(0, 0, z);
    p.material = materialOf(pattern, paint, car, pattern == Pattern::kCarCabin ? 0.15F : 0.6F);
    p.object = object_;
    p.motion = motion;
    add(p);
  };
  const double top = is_van ? 0.45 : 0.28;
  addPart(
      {{-2.02, -0.36}, {2.02, -0.36}, {2.14, -0.16}, {2.1, 0.1}, {1.9, 0.2}, {1.2, top}, {-1.85, top}, {-2.08, 0.2}},
      0.88, 0.6, Pattern::kCarBody);
  if (is_van) {
    addPart({{-2.02, 0}, {1.5, 0}, {0.9, 0.85}, {0.6, 0.95}, {-1.9, 0.95}}, 0.84, 0.6 + top, Pattern::kCarCabin);
  } else {
    addPart({{-1.7, 0}, {1.15, 0}, {0.4, 0.54}, {0.1, 0.6}, {-0.9, 0.6}, {-1.2, 0.54}}, 0.76, 0.6 + top,
            Pattern::kCarCabin);
  }
  for (const double x : {-1.3, 1.32}) {
    for (const double y : {-0.8, 0.8}) {
      Primitive wheel =
          uprightCylinder({0, 0, 0}, 0.32, 0.2, materialOf(Pattern::kWheel, Color(34, 34, 36), 0, 0.1F), object_);
      wheel.map_from_local =
          map_from_car * Eigen::Translation3d(x, y, 0.32) * Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitX());
      wheel.motion = motion;
      add(wheel);
    }
  }
}

/// On a pavement, or across the carriageway.
void StreetBuilder::addPedestrian(int number) {
  static const std::array<Color, 5> kCoats = {Color(52, 54, 62), Color(150, 40, 44), Color(196, 188, 170),
                                              Color(40, 70, 120), Color(92, 104, 70)};
  next();
  const std::uint64_t walker = key(60, number);
  const int side = number % 2 == 0 ? 1 : -1;
  const bool crosses = number % 3 == 2;
  const double speed = (uniform(keyOf(walker, 1)) < 0.5 ? -1 : 1) * uniform(keyOf(walker, 2), 0.9, 1.6);
  const auto motion = steady(crosses ? Eigen::Vector3d(0, -side * std::abs(speed), 0) : Eigen::Vector3d(speed, 0, 0));
  const Eigen::Vector3d foot(6 + 5.5 * number, side * (kRoad + (crosses ? 0.2 : uniform(keyOf(walker, 3), 0.9, 1.5))),
                             crosses ? 0.01 : kKerbHeight);
  const auto part = [&](Primitive primitive) {
    primitive.motion = motion;
    add(primitive);
  };
  part(uprightCylinder(foot, 0.14, 0.85, materialOf(Pattern::kPlain, Color(56, 58, 70), 0, 0.4F), object_));
  part(uprightCylinder(foot + Eigen::Vector3d(0, 0, 0.85), 0.24, 0.6,
                       materialOf(Pattern::kPlain, pick(kCoats, keyOf(walker, 4)), 0, 0.5F), object_));
  Primitive head;
  head.shape = Shape::kSphere;
  head.radius = 0.12;
  head.map_from_local.translation() = foot + Eigen::Vector3d(0, 0, 1.58);
  head.material = materialOf(Pattern::kPlain, Color(190, 150, 124), 0, 0.5F);
  head.object = object_;
  part(head);
}

void StreetBuilder::addLamps(int side) {
  const Material metal = materialOf(Pattern::kPlain, Color(72, 80, 84), 0, 0.35F);
  for (double x = options_.from + (side > 0 ? 9 : 18); x < options_.to; x += 18) {
    next();
    const Eigen::Vector3d foot(x, side * (kRoad + 0.5), kKerbHeight - 0.01);
    add(uprightCylinder(foot, 0.1, 1.1, metal, object_));
    add(uprightCylinder(foot, 0.06, 6.2, metal, object_));
    const double y = foot.y();
    addBox({x - 0.04, std::min(y, y - side * 1.5), 6.1}, {x + 0.04, std::max(y, y - side * 1.5), 6.2}, metal);
    addBox({x - 0.15, std::min(y - side * 1.2, y - side * 1.8), 6.02},
           {x + 0.15, std::max(y - side * 1.2, y - side * 1.8), 6.12},
           materialOf(Pattern::kPlain, Color(214, 212, 196), 0, 0.5F));
    // A litter bin beside it.
    Material bin = materialOf(Pattern::kBands, Color(38, 96, 72), 0, 0.4F);
    bin.accent = Color(46, 116, 88);
    add(uprightCylinder(foot + Eigen::Vector3d(0.55, 0, 0), 0.22, 0.85, bin, object_));
  }
}

void StreetBuilder::addTreesAndSigns(int side) {
  for (int i = 0;; ++i) {
    const std::uint64_t place = key(30, side, i);
    const double x = options_.from + 4.5 + 9 * i + uniform(keyOf(place, 1), -1, 1);
    if (x > options_.to - 2) break;
    const double kind = uniform(keyOf(place, 2));
    const Eigen::Vector3d foot(x, side * (kRoad + 0.65), kKerbHeight - 0.01);
    if (kind < 0.33) {
      addTree(foot, place);
    } else if (kind < 0.75) {
      addSign(foot, place);
    } else {
      next();
      for (int post = 0; post < 4; ++post) {
        add(uprightCylinder(foot + Eigen::Vector3d(1.2 * post - 1.8, -side * 0.25, 0), 0.07, 0.95,
                            materialOf(Pattern::kPlain, Color(150, 60, 48), 0, 0.5F), object_));
      }
    }
  }
}

void StreetBuilder::addTree(const Eigen::Vector3d& foot, std::uint64_t tree) {
  static const std::array<Color, 4> kGreens = {Color(84, 124, 56), Color(104, 138, 62), Color(70, 112, 62),
                                               Color(132, 140, 60)};
  next();
  const double height = uniform(keyOf(tree, 3), 2.4, 3.2);
  add(uprightCylinder(foot, 0.14, height, materialOf(Pattern::kBark, Color(104, 84, 66), tree, 0.4F), object_));
  const int num_balls = options_.leaves > 0 ? options_.leaves : 14;
  for (int i = 0; i < num_balls; ++i) {
    Primitive crown;
    crown.shape = Shape::kSphere;
    const double angle = 0.9 * i + uniform(keyOf(tree, 5));
    const double out = i == 0 ? 0 : uniform(keyOf(tree, 6, i), 0.35, 1.0);
    const double up = uniform(keyOf(tree, 7, i), 0.1, 1.7);
    crown.radius = uniform(keyOf(tree, 4, i), 0.35, 0.75);
    // Single leaves fill the same crown and leave it open.
    if (options_.leaves > 0) crown.radius *= 0.13;
    const double spread = options_.leaves > 0 ? 1.4 : 1;
    crown.map_from_local.translation() =
        foot + Eigen::Vector3d(spread * out * std::cos(angle), spread * out * std::sin(angle), height + up);
    crown.material = materialOf(Pattern::kLeaves, pick(kGreens, keyOf(tree, 8)), keyOf(tree, i), 0.7F);
    crown.object = object_;
    add(crown);
  }
}

void StreetBuilder::addSign(const Eigen::Vector3d& foot, std::uint64_t sign) {
  next();
  add(uprightCylinder(foot, 0.05, 2.6, materialOf(Pattern::kPlain, Color(150, 154, 156), 0, 0.6F), object_));
  Primitive plate;
  plate.shape = Shape::kCylinder;
  plate.radius = 0.34;
  plate.half_length = 0.012;
  // Its upper end looks at the traffic that drives on this side: towards -x on the right, +x on the left.
  const double yaw = foot.y() < 0 ? kPi : 0;
  const Eigen::Vector3d towards(std::cos(yaw), 0, 0);
  plate.map_from_local = Eigen::Translation3d(foot + Eigen::Vector3d(0, 0, 2.25) + 0.07 * towards) *
                         Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitX());
  plate.material = materialOf(Pattern::kSign, Color(190, 30, 36), keyOf(sign, 9), 0.95F);
  plate.object = object_;
  add(plate);
}

}  // namespace

std::vector<Primitive> streetPrimitives(const StreetOptions& options) {
  require<std::invalid_argument>(options.to - options.from >= 20, "street of ", options.to - options.from,
                                 " m is too short, needs 20 m");
  return StreetBuilder(options).build();
}

Scene makeStreet(const StreetOptions& options, int num_threads) {
  return Scene(streetPrimitives(options), options.lighting, num_threads);
}

}  // namespace cloud_colorizer::simulation
