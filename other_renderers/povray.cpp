// SPDX-License-Identifier: Apache-2.0

// POV-Ray 3.7, whose radiosity knows qualities but no samples.
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <ranges>
#include <regex>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "other_renderers/export.h"
#include "other_renderers/plumbline.inc.h"

namespace plumb {
namespace {

std::string vector(const Vec3& v) { return fmt::format("<{}, {}, {}>", v.x, v.y, v.z); }

// "first, second, ...".
std::string corner_list(const std::vector<Vec3>& corners) {
  return fmt::format("{}", fmt::join(corners | std::views::transform(vector), ", "));
}

std::string sphere(const Sphere& sphere) {
  return fmt::format("{}, {}", vector(sphere.center), sphere.radius);
}

// A mesh stores its corners in single precision, which shows where surfaces all but touch, as a
// lamp's glow does. But a union that isn't split is searched from end to end: mirrors of 20,000
// triangles took 135 s as a union and 1 s as a mesh.
constexpr size_t mesh_from = 200;

std::string surface(const Shape& shape) {
  if (const auto* ball = std::get_if<Sphere>(&shape.geometry)) {
    return fmt::format("sphere {{ {} Surface() }}\n", sphere(*ball));
  }
  const Mesh& polygons = std::get<Mesh>(shape.geometry);
  const bool is_mesh = polygons.size() >= mesh_from && !shape.is_lamp();
  std::string text = is_mesh ? "mesh {\n" : "union {\n";
  for (const Polygon& polygon : polygons) {
    text += fmt::format("  {}({})\n", polygon.corners.size() == 3 ? "Triangle" : "Quad",
                        corner_list(polygon.corners));
  }
  // Else photons are aimed at every triangle by itself, and those that miss it count for others.
  if (!is_mesh && shape.bsdf.is_specular()) text += "  split_union off\n";
  return text + "  Surface()\n}\n";
}

// The point of the polygon that is nearest to `p`.
Vec3 nearest(const std::vector<Vec3>& corners, const Vec3& normal, const Vec3& p) {
  Vec3 best = corners[0];
  bool is_inside = true;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3& a = corners[i];
    const Vec3 edge = corners[(i + 1) % corners.size()] - a;
    const double t = std::clamp((p - a).dot(edge) / edge.dot(edge), 0.0, 1.0);
    if ((p - a - t * edge).length() < (p - best).length()) best = a + t * edge;
    is_inside = is_inside && edge.cross(p - a).dot(normal) >= 0.0;
  }
  return is_inside ? p - (p - corners[0]).dot(normal) * normal : best;
}

// A polygon or sphere of a lamp, from which distances to what it shines on are measured.
struct LampPart {
  std::vector<Vec3> corners;  // none: a sphere
  Vec3 normal;
  Sphere bounds;

  explicit LampPart(const Sphere& sphere) : bounds(sphere) {}
  explicit LampPart(const Polygon& polygon)
      : corners(polygon.corners), normal(polygon.normal()), bounds{Vec3(0.0), 0.0} {
    for (const Vec3& corner : corners) bounds.center += corner;
    bounds.center /= static_cast<double>(corners.size());
    for (const Vec3& corner : corners) {
      bounds.radius = std::max(bounds.radius, (corner - bounds.center).length());
    }
  }

  bool shines_on(const Vec3& point, const Vec3& facing) const {
    if (corners.empty()) return (bounds.center - point).dot(facing) > -bounds.radius;
    return std::ranges::any_of(corners, [&](const Vec3& corner) {
      return (corner - point).dot(facing) > 1e-6 * bounds.radius;
    });
  }

  double distance_to(const Polygon& polygon, bool two_sided) const {
    const Vec3 facing = polygon.normal();
    if (!two_sided && !shines_on(polygon.corners[0], facing)) return far;
    if (corners.empty()) {
      const Vec3 point = nearest(polygon.corners, facing, bounds.center);
      return std::max(0.0, (point - bounds.center).length() - bounds.radius);
    }
    // What is all but in the lamp's plane gets no light.
    const std::vector<Vec3> lit =
        part_beyond(polygon.corners, normal, corners[0].dot(normal) + least_height * bounds.radius);
    if (lit.size() < 3) return far;
    // Projections on one and the other in turns lead to the two points that are nearest.
    Vec3 here = bounds.center;
    Vec3 there = here;
    for (int i = 0; i < 32; ++i) {
      there = nearest(lit, facing, here);
      here = nearest(corners, normal, there);
    }
    return (there - here).length();
  }

  double distance_to(const Sphere& sphere) const {
    if (corners.empty()) {
      return std::max(0.0,
                      (sphere.center - bounds.center).length() - sphere.radius - bounds.radius);
    }
    const double height = (sphere.center - corners[0]).dot(normal);
    if (height + sphere.radius <= least_height * bounds.radius) return far;
    return std::max(
        0.0, (nearest(corners, normal, sphere.center) - sphere.center).length() - sphere.radius);
  }

  // To the nearest matte surface that it shines on; `far`, if that is further than `enough`.
  double distance_to(const std::vector<Shape>& shapes, double enough) const {
    double distance = far;
    for (const Shape& shape : shapes) {
      const Bsdf& bsdf = shape.bsdf;
      if (bsdf.is_specular() || bsdf.reflectance == Rgb(0.0)) continue;
      if (const auto* ball = std::get_if<Sphere>(&shape.geometry)) {
        const bool is_itself = corners.empty() && ball->center == bounds.center;
        if (!is_itself) distance = std::min(distance, distance_to(*ball));
        continue;
      }
      for (const Polygon& polygon : std::get<Mesh>(shape.geometry)) {
        const Vec3 point = nearest(polygon.corners, polygon.normal(), bounds.center);
        if ((point - bounds.center).length() - bounds.radius > enough) continue;
        distance = std::min(distance, distance_to(polygon, bsdf.two_sided));
      }
    }
    return distance;
  }

  static constexpr double far = 1e300;
  static constexpr double least_height = 0.02;
};

// The error of a grid's light falls as exp(-2 pi distance / step): to 0.2 % where it is one step
// away, as with these factors it is for the grid of a good picture. The largest is what can be
// afforded. The lamp's border adds an error of the midpoint rule, which falls with the square of
// the step: straight below a square that is as far away as its side is long, +0.53 % with 6 lights
// along a side, 0.30 % with 8 and 0.07 % with 16.
constexpr double usual_grid = 8.0;
constexpr double largest_factor = 4.0;

// The factor on the number of lights along a side of a lamp that is the fraction `share` of all
// that its shape emits from, and at a distance from what it shines on. Rounded up, so that exported
// numbers don't hang on the last bit.
double light_factor(double side, double distance, double share) {
  const double least = std::min(1.0, 4.0 * std::sqrt(share));
  const double wanted = side / (usual_grid * std::max(distance, 1e-300));
  const double factor = std::clamp(wanted, least, largest_factor * least);
  return std::ceil(factor * 16.0 - 1e-6) / 16.0;
}

double area(const Polygon& polygon) {
  Vec3 sum(0.0);
  for (size_t i = 1; i + 1 < polygon.corners.size(); ++i) {
    sum += (polygon.corners[i] - polygon.corners[0])
               .cross(polygon.corners[i + 1] - polygon.corners[0]);
  }
  return 0.5 * sum.length();
}

std::string lamp(const Scene& scene, const Shape& shape) {
  const std::string radiance = vector(shape.radiance);
  if (const auto* ball = std::get_if<Sphere>(&shape.geometry)) {
    // 4 N^2 lights on the sphere are as dense as N^2 on a square of this side.
    const double side = std::sqrt(std::numbers::pi) * ball->radius;
    const double distance = LampPart(*ball).distance_to(scene.shapes, side / usual_grid);
    return fmt::format("Sphere_lamp({}, {}, {})\n", sphere(*ball), radiance,
                       light_factor(side, distance, 1.0));
  }
  const Mesh& polygons = std::get<Mesh>(shape.geometry);
  double whole = 0.0;
  for (const Polygon& polygon : polygons) whole += area(polygon);
  std::string text;
  for (const Polygon& polygon : polygons) {
    const std::vector<Vec3>& corner = polygon.corners;
    const double x = (corner[1] - corner[0]).length();
    const double y = (corner.back() - corner[0]).length();
    const double diagonal = (corner[2] - corner[1]).length();
    const double longest = std::max({x, y, diagonal});
    const double distance = LampPart(polygon).distance_to(scene.shapes, longest / usual_grid);
    const double share = area(polygon) / whole;
    if (polygon.is_rectangle()) {
      text += fmt::format("Rectangle_lamp({}, {}, {}, {})\n",
                          corner_list({corner[0], corner[1], corner[3]}), radiance,
                          light_factor(x, distance, share), light_factor(y, distance, share));
      continue;
    }
    for (size_t i = 1; i + 1 < corner.size(); ++i) {
      text += fmt::format("Triangle_lamp({}, {}, {})\n",
                          corner_list({corner[0], corner[i], corner[i + 1]}), radiance,
                          light_factor(longest, distance, share));
    }
  }
  return text;
}

std::string camera(const Camera& camera) {
  return fmt::format("Camera({}, {},\n       {}, {}, {})\n", vector(camera.origin),
                     vector(camera.forward), vector(camera.right), vector(camera.up),
                     camera.half_width());
}

std::string filter_note(const Scene& scene) {
  return box_filter_note("POV-Ray", scene.camera.filter);
}

std::string notes(const Scene& scene) {
  std::string notes = filter_note(scene);
  if (std::ranges::any_of(scene.shapes, [](const Shape& shape) {
        return is_glass(shape) && shape.bsdf.reflectance != Rgb(1.0);
      })) {
    notes += notes.empty() ? "" : "; ";
    notes += "POV-Ray lets glass transmit what its reflectance doesn't reflect";
  }
  return notes;
}

void refuse(const std::string& what) { throw std::invalid_argument("POV-Ray can't draw " + what); }

// Throws std::invalid_argument for what would be wrong.
void check(const Scene& scene) {
  const Media media(scene.shapes);
  // In glass radiance isn't what it is in the air. Gathering rays don't know it, but photons do.
  const Vec3& eye = scene.camera.origin;
  if (media.index_at(eye) != 1.0) refuse("what a camera in glass sees");
  const bool has_glass = std::ranges::any_of(scene.shapes, is_glass);
  if (scene.has_sky()) refuse("a sky: only gathering rays would meet it, a bounce too late");
  if (!scene.points.empty() && std::ranges::any_of(scene.shapes, [](const Shape& shape) {
        return shape.bsdf.is_specular();
      })) {
    refuse("point lamps with mirrors or glass: its photons find what no path does");
  }
  for (const Shape& shape : scene.shapes) {
    const Bsdf& bsdf = shape.bsdf;
    if (bsdf.alpha > 0.0) refuse(shape.id + ": it has no rough reflections");
    if (is_glass(shape)) Media({shape}).index_before(shape);  // its way in has a way out
    if (shape.is_lamp() && (is_glass(shape) || bsdf.is_metal())) {
      refuse(shape.id + ", a lamp of glass or metal");
    }
    const bool is_unseen = bsdf.kind == Bsdf::Kind::diffuse && bsdf.reflectance == Rgb(0.0);
    const bool is_mirror = bsdf.kind == Bsdf::Kind::conductor;
    if ((shape.is_lamp() || !(is_unseen || is_mirror)) && media.index_before(shape) != 1.0) {
      refuse(shape.id + " in glass: only mirrors and what is black");
    }
    // Glass that is within any solid reflects nothing inside.
    const auto* ball = std::get_if<Sphere>(&shape.geometry);
    if (has_glass && ball != nullptr && (ball->center - eye).length() <= ball->radius) {
      refuse("glass from within " + shape.id);
    }
  }
}

std::string scattering(const Shape& shape) {
  const Bsdf& bsdf = shape.bsdf;
  const std::string reflectance = vector(bsdf.reflectance);
  if (is_glass(shape)) {
    return fmt::format("Glass({}, {}, {})", reflectance, vector(bsdf.transmittance), bsdf.ior);
  }
  const char* both_sides = bsdf.two_sided ? "yes" : "no";
  if (bsdf.is_metal()) {
    return fmt::format("Metal({}, {}, {}, {})", reflectance, vector(bsdf.eta), vector(bsdf.k),
                       both_sides);
  }
  return fmt::format("{}({}, {})", bsdf.is_specular() ? "Conductor" : "Diffuse", reflectance,
                     both_sides);
}

std::string scene_text(const Scene& scene) {
  check(scene);
  std::string text = fmt::format(
      "// {}, for POV-Ray 3.7: povray FILE +W{} +H{}\n{}"
      "#version 3.7;\n#include \"plumbline.inc\"\n\n{}",
      plain_identifier(scene.name), scene.camera.width, scene.camera.height,
      comment("// ", notes(scene)), camera(scene.camera));
  for (const Shape& shape : scene.shapes) {
    text += fmt::format("\n// {}\n{}\n{}", plain_identifier(shape.id), scattering(shape),
                        surface(shape));
    if (shape.is_lamp()) text += lamp(scene, shape);
  }
  for (const PointLamp& point : scene.points) {
    text += fmt::format("\nPoint_lamp({}, {})\n", vector(point.position), vector(point.intensity));
  }
  return text;
}

// Anti-aliasing with `depth` x `depth` jittered rays in every pixel.
Command command(const Job& job, int depth, std::optional<int> bounces,
                const Command& declarations) {
  Command command{"povray",
                  "+I" + job.file.filename().string(),
                  fmt::format("+O{}", picture_name),
                  fmt::format("+W{}", job.scene.camera.width),
                  fmt::format("+H{}", job.scene.camera.height),
                  fmt::format("+R{}", depth)};
  command.insert(command.end(), {"+FE", "-D", "+A0.0", "+AM1", "+J1"});
  if (job.settings.threads > 0) command.push_back(fmt::format("+WT{}", job.settings.threads));
  if (bounces) command.push_back(fmt::format("Declare=Max_bounces={}", *bounces));
  for (const std::string& declaration : declarations) {
    command.push_back("Declare=" + declaration);
  }
  return command;
}

// Lamps as the camera sees them, direct light from many points of the lamps, and what further
// bounces add where the lamps have fewer points, which every gathered ray has to ask.
std::vector<Run> runs(const Job& job) {
  constexpr std::array<int, 3> emission_depth{5, 9, 9};
  constexpr std::array<int, 3> direct_depth{3, 3, 5};
  constexpr std::array<int, 3> direct_grid{6, 8, 16};
  const auto quality = size_t(job.settings.quality);
  std::vector<Run> runs{{command(job, emission_depth[quality], 0, {})}};
  if (job.most_bounces == 0) return runs;
  runs.push_back({command(job, direct_depth[quality], 1,
                          {"Emission=0", fmt::format("Lamp_grid={}", direct_grid[quality])})});
  if (job.most_bounces == 1) return runs;
  const Command coarse{"Emission=0", "Lamp_grid=4", "Lamp_detail=0",
                       fmt::format("Quality={}", quality)};
  runs.push_back({command(job, 3, job.most_bounces, coarse), 1.0});
  runs.push_back({command(job, 3, 1, coarse), -1.0});
  return runs;
}

// Scenes can't know the version and the seconds.
RunReport read_log(const std::string& log) {
  std::smatch version;
  std::regex_search(log, version, std::regex(R"(Ray Tracer Version ([0-9.]*[0-9]))"));
  RunReport report{"POV-Ray " + version.str(1), version.str(1)};
  const std::string times = log.substr(log.rfind("Render Time:"));
  const std::regex time(R"(\(([0-9.]+) seconds\))");
  for (std::sregex_iterator match(times.begin(), times.end(), time), end; match != end; ++match) {
    report.seconds += std::stod(match->str(1));
  }
  return report;
}

}  // namespace

OtherRenderer povray() {
  return {.word = "povray",
          .name = "POV-Ray",
          .software = "POV-Ray",
          .probe = {"povray", "--version"},
          .how_to_install = "POV-Ray is not installed: 'apt-get install povray', or see povray.org",
          .has_samples = false,
          .counts_mirror_bounces = false,
          .script_name = "plumbline.inc",
          .script = plumbline_inc,
          .format = SceneFormat{".pov", scene_text},
          .drawn_otherwise = notes,
          .runs = runs,
          .read_log = read_log};
}

}  // namespace plumb
