// SPDX-License-Identifier: MIT
// Random numbers and circular functions that have the same bits on every platform, for
// generate.cc: the distributions of the standard library and its sines may differ.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>

#include "engine/base/buffer.h"
#include "engine/base/vec3.h"

namespace limn::generate {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  // In [0, 1), with 53 bits.
  double Uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  // In [low, high).
  double Between(double low, double high) { return low + (high - low) * Uniform(); }
  // In [0, n). n is 1 or more and below 2^53.
  std::uint64_t Below(std::uint64_t n) {
    return static_cast<std::uint64_t>(Uniform() * static_cast<double>(n));
  }
  // A random order.
  template <class T>
  void Shuffle(Buffer<T>* items) {
    for (std::size_t i = items->size(); i > 1; --i) {
      std::swap((*items)[i - 1], (*items)[static_cast<std::size_t>(Below(i))]);
    }
  }

 private:
  std::mt19937_64 engine_;
};

// Sine of an angle in turns (1 is a full circle), |turns| < 2^52. Within 1e-15.
inline double SinTurns(double turns) {
  double t = turns - std::floor(turns + 0.5);  // in [-1/2, 1/2)
  if (t > 0.25) t = 0.5 - t;
  if (t < -0.25) t = -0.5 - t;
  constexpr double kTwoPi = 6.283185307179586476925;
  const double x = kTwoPi * t;
  const double square = x * x;
  // Taylor's series up to x^23 / 23!, below 1e-17 at a quarter turn.
  double sum = 1;
  for (int k = 22; k >= 2; k -= 2) sum = 1 - square / (k * (k + 1)) * sum;
  return x * sum;
}

inline double CosTurns(double turns) { return SinTurns(turns + 0.25); }

// A smooth function of space, the sum of some plane waves: between -1 and 1.
class Waves {
 public:
  // `frequency`: waves per unit length of the finest.
  Waves(Random* random, double frequency) {
    for (std::size_t i = 0; i < kCount; ++i) {
      Vec3 axis;
      do {  // Uniform in the ball, then on the sphere.
        axis = {random->Between(-1, 1), random->Between(-1, 1), random->Between(-1, 1)};
      } while (Dot(axis, axis) > 1 || Dot(axis, axis) < 1e-4);
      const double share = static_cast<double>(i + 1) / kCount;
      axis_[i] = NormalizedOrZero(axis) * (frequency * share);
      phase_[i] = random->Uniform();
      amplitude_[i] = 1 / (kCount * (0.5 + share));
    }
  }

  double At(const Vec3& point) const {
    double sum = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      sum += amplitude_[i] * SinTurns(Dot(axis_[i], point) + phase_[i]);
    }
    return sum;
  }

 private:
  static constexpr std::size_t kCount = 6;
  std::array<Vec3, kCount> axis_;
  std::array<double, kCount> phase_;
  std::array<double, kCount> amplitude_;
};

}  // namespace limn::generate
