#include "viewer/aovs/fit_camera.h"

#include <array>
#include <cmath>
#include <vector>

namespace relume {
namespace {

constexpr size_t unknowns = 8;
using Row = std::array<double, unknowns>;
using Matrix = std::array<Row, unknowns>;

/// Rotates rows and columns p and q so that the element between them becomes 0 (Jacobi).
void rotate(Matrix& m, Matrix& vectors, size_t p, size_t q) {
  if (m[p][q] == 0) return;
  const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
  const double sign = theta < 0 ? -1 : 1;
  const double t = sign / (std::abs(theta) + std::sqrt(theta * theta + 1));
  const double c = 1 / std::sqrt(t * t + 1);
  const double s = t * c;
  for (size_t k = 0; k < unknowns; ++k) {
    const double kp = m[k][p];
    const double kq = m[k][q];
    m[k][p] = c * kp - s * kq;
    m[k][q] = s * kp + c * kq;
  }
  for (size_t k = 0; k < unknowns; ++k) {
    const double pk = m[p][k];
    const double qk = m[q][k];
    m[p][k] = c * pk - s * qk;
    m[q][k] = s * pk + c * qk;
    const double vp = vectors[k][p];
    const double vq = vectors[k][q];
    vectors[k][p] = c * vp - s * vq;
    vectors[k][q] = s * vp + c * vq;
  }
}

/// The unit vector that the symmetric, positive matrix shrinks most; nothing where another one is
/// about as short.
std::optional<Row> null_vector(Matrix m) {
  Matrix vectors{};
  for (size_t i = 0; i < unknowns; ++i) vectors[i][i] = 1;
  constexpr int sweeps = 30;  // converges quadratically
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (size_t p = 0; p < unknowns; ++p) {
      for (size_t q = p + 1; q < unknowns; ++q) rotate(m, vectors, p, q);
    }
  }
  std::array<size_t, unknowns> order{};
  for (size_t i = 0; i < unknowns; ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return m[a][a] < m[b][b]; });
  const double least = std::abs(m[order[0]][order[0]]);
  const double next = m[order[1]][order[1]];
  const double largest = m[order.back()][order.back()];
  if (!(next > 1e-9 * largest) || !(next > 4 * least)) return std::nullopt;
  Row result{};
  for (size_t i = 0; i < unknowns; ++i) result[i] = vectors[i][order[0]];
  return result;
}

/// A point relative to the middle of the points and of the picture: film x to the right and y up,
/// in halves of the picture's height.
struct CenteredPoint {
  dvec3 position;
  double x;
  double y;
};

struct CenteredPoints {
  std::vector<CenteredPoint> points;  ///< none where all are in one place
  dvec3 center{0};
  double scale = 0;
};

CenteredPoints center_points(std::span<const SeenPoint> points, int width, int height) {
  CenteredPoints result;
  for (const SeenPoint& point : points) result.center += dvec3(point.position);
  result.center /= static_cast<double>(points.size());
  for (const SeenPoint& point : points) {
    result.scale = std::max(result.scale, glm::distance(dvec3(point.position), result.center));
  }
  if (!(result.scale > 0)) return result;
  for (const SeenPoint& point : points) {
    result.points.push_back({(dvec3(point.position) - result.center) / result.scale,
                             (2.0 * point.film_px.x - width) / height,
                             (height - 2.0 * point.film_px.y) / height});
  }
  return result;
}

/// Right and up, times one factor, and their products with the eye: y (right . p - right . eye) =
/// x (up . p - up . eye) for every point.
std::optional<Row> fit_film_axes(const std::vector<CenteredPoint>& points) {
  Matrix normal{};
  for (const CenteredPoint& point : points) {
    const dvec3& p = point.position;
    const Row row = {point.y * p.x,  point.y * p.y,  point.y * p.z,  -point.y,
                     -point.x * p.x, -point.x * p.y, -point.x * p.z, point.x};
    for (size_t i = 0; i < unknowns; ++i) {
      for (size_t k = 0; k < unknowns; ++k) normal[i][k] += row[i] * row[k];
    }
  }
  return null_vector(normal);
}

/// Focal length f, in halves of the height, and t = forward . eye, from x (forward . p - t) =
/// f (right . p - r) and the same for y.
struct DepthFit {
  double focal = 0;
  double eye_depth = 0;
};

DepthFit fit_depth(const std::vector<CenteredPoint>& points, dvec3 right, double r, dvec3 up,
                   double u) {
  const dvec3 forward = glm::cross(up, right);
  double aa = 0;
  double ab = 0;
  double bb = 0;
  double ac = 0;
  double bc = 0;
  const auto add = [&](double a, double b, double c) {
    aa += a * a;
    ab += a * b;
    bb += b * b;
    ac += a * c;
    bc += b * c;
  };
  for (const CenteredPoint& point : points) {
    const double along = glm::dot(forward, point.position);
    add(glm::dot(right, point.position) - r, point.x, point.x * along);
    add(glm::dot(up, point.position) - u, point.y, point.y * along);
  }
  const double determinant = aa * bb - ab * ab;
  if (!(determinant > 1e-9 * aa * bb)) return {};
  return {(ac * bb - bc * ab) / determinant, (aa * bc - ab * ac) / determinant};
}

}  // namespace

std::optional<Camera> fit_camera(std::span<const SeenPoint> points, int width, int height) {
  constexpr size_t fewest = 16;
  if (points.size() < fewest) return std::nullopt;
  const CenteredPoints centered = center_points(points, width, height);
  if (!(centered.scale > 0)) return std::nullopt;
  const std::optional<Row> axes = fit_film_axes(centered.points);
  if (!axes) return std::nullopt;
  const Row& v = *axes;
  const dvec3 right_scaled(v[0], v[1], v[2]);
  const dvec3 up_scaled(v[4], v[5], v[6]);
  const double factor = std::sqrt(glm::length(right_scaled) * glm::length(up_scaled));
  if (!(factor > 1e-12)) return std::nullopt;
  double sign = 1;
  for (int attempt = 0; attempt < 2; ++attempt, sign = -1) {
    const dvec3 right = glm::normalize(sign * right_scaled);
    const dvec3 across = sign * up_scaled - glm::dot(sign * up_scaled, right) * right;
    const dvec3 up = glm::normalize(across);
    const double r = sign * v[3] / factor;
    const double u = sign * v[7] / factor;
    const DepthFit depth = fit_depth(centered.points, right, r, up, u);
    if (!(depth.focal > 0)) continue;
    const dvec3 forward = glm::cross(up, right);
    const dvec3 eye =
        centered.center + centered.scale * (right * r + up * u + forward * depth.eye_depth);
    const double distance = -depth.eye_depth * centered.scale;
    if (!(distance > 0)) return std::nullopt;
    constexpr double degrees_per_radian = 180 / 3.14159265358979323846;
    return Camera{
        .eye = vec3(eye),
        .target = vec3(eye + forward * distance),
        .up = vec3(up),
        .fov_y_deg = static_cast<float>(2 * std::atan(1 / depth.focal) * degrees_per_radian)};
  }
  return std::nullopt;
}

}  // namespace relume
