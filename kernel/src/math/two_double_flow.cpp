#include "math/two_double_flow.hpp"

#include <algorithm>
#include <cmath>

#include "math/elementary.hpp"

// Equation   y'' + q y' + w y = s^(k-2)/(k-2)!, s = 0..1, from y = y' = 0: y(1) = psi_k, y'(1) = psi_{k-1}  (psi.hpp).
// Solution   scaling and doubling (Higham, Functions of Matrices, 2008, section 10.3, for the exponential): on a step of 2^-m
//            Taylor's series needs few terms; two equal steps then make one of twice the length, m times. With all numbers
//            taken at the small step and c = 1 - w psi_2, the free motion of a unit displacement:
//              2   psi_1' = psi_1 (c + psi_0)
//              2^k psi_k' = c psi_k + psi_1 psi_{k-1} + sum_{i=2..k} psi_i / (k-i)!
//            Each sums the free motion of what the first half left and the second half's own force, s^(k-2) expanded about its
//            middle.
// Why        one formula for oscillating, critical, overdamped, resonant and free motion, with nothing to switch between. Each
//            doubling doubles the error in phase: 2^-104 has become 2^-54 after 50 of them. Damping only damps the errors.
// Limits     beyond 2^50 radians the phase of a double has lost its meaning: there psi() serves.

namespace dvdx {
namespace {

constexpr double farthest = 0x1p+50;
constexpr int taylor_terms = 32;  // roots within 0.81: 0.81^32 33/33! < 2^-115

// The number of times that the step is halved until x <= 1/2.
int halvings(double x) noexcept {
  int exponent = 0;
  std::frexp(x, &exponent);
  return std::max(0, exponent + 1);
}

double factorial(int n) noexcept { return n < 2 ? 1.0 : n * factorial(n - 1); }

// psi_{k-1} and psi_k: sums of d_n/(n+k-1)! and d_n/(n+k)!.
struct Pair {
  TwoDouble before, last;
};
Pair taylor(TwoDouble w, TwoDouble q, int k) noexcept {
  TwoDouble d = 1.0, next = -q;
  Pair sum;
  TwoDouble inverse = TwoDouble(1.0) / factorial(k - 1);
  for (int n = 0; n < taylor_terms; ++n) {
    sum.before += d * inverse;
    inverse = inverse / static_cast<double>(n + k);
    sum.last += d * inverse;
    const TwoDouble after = -(q * next + w * d);
    d = next;
    next = after;
    if (std::abs(d.high) + std::abs(next.high) < 0x1p-112) break;
  }
  return sum;
}

TwoDouble& at(PsiTable& table, int k) noexcept { return table[static_cast<std::size_t>(k)]; }
TwoDouble at(const PsiTable& table, int k) noexcept { return table[static_cast<std::size_t>(k)]; }

PsiTable small_step(TwoDouble w, TwoDouble q, int top) noexcept {
  PsiTable psi;
  const Pair series = taylor(w, q, top);
  at(psi, top) = series.last;
  at(psi, top - 1) = series.before;
  for (int k = top - 1; k >= 1; --k) {  // downwards the recurrence only subtracts small terms from 1/(k-1)!
    at(psi, k - 1) = TwoDouble(1.0) / factorial(k - 1) - (q * at(psi, k) + w * at(psi, k + 1));
  }
  return psi;
}

PsiTable doubled(PsiTable psi, TwoDouble w, TwoDouble q, int top) noexcept {
  const TwoDouble one = 1.0;
  const TwoDouble c = one - w * psi[2];
  PsiTable twice;
  // 1 - (1 - c + 1 - psi_0)/2 rather than (c + psi_0)/2: the small difference from 1 is what counts.
  twice[1] = psi[1] - psi[1] * (scaled(q * psi[1], -1) + w * psi[2]);
  for (int k = 2; k <= top; ++k) {
    TwoDouble sum = c * at(psi, k) + psi[1] * at(psi, k - 1);
    for (int i = 2; i <= k; ++i) sum += at(psi, i) / factorial(k - i);
    at(twice, k) = scaled(sum, -k);
  }
  const TwoDouble w4 = scaled(w, 2), q2 = scaled(q, 1);
  twice[0] = one - (q2 * twice[1] + w4 * twice[2]);
  return twice;
}

// For q > 2^100 only the slow root, -w/q, is left, and the strength 1/q of the fast one.
PsiTable creeping(TwoDouble w, TwoDouble q, int top) noexcept {
  const PsiTable phi = flow(0.0, w / q, top);
  PsiTable psi;
  for (int k = 1; k <= top; ++k) at(psi, k) = at(phi, k - 1) / q;
  psi[0] = TwoDouble(1.0) - (q * psi[1] + w * psi[2]);
  return psi;
}

// Takes the recurrence upwards: it divides by w, which is large here.
PsiTable ringing(TwoDouble w, TwoDouble q, int top) noexcept {
  const Psi low = dvdx::psi(w.high, q.high);
  PsiTable psi = {low.psi0, low.psi1, low.psi2, low.psi3};
  for (int k = 3; k < top; ++k) {
    at(psi, k + 1) = (TwoDouble(1.0) / factorial(k - 1) - at(psi, k - 1) - q * at(psi, k)) / w;
  }
  return psi;
}

Complex operator+(const Complex& a, const Complex& b) noexcept { return {a.re + b.re, a.im + b.im}; }
Complex operator-(const Complex& a, const Complex& b) noexcept { return {a.re - b.re, a.im - b.im}; }
Complex operator*(const Complex& a, TwoDouble b) noexcept { return {a.re * b, a.im * b}; }
Complex operator*(const Complex& a, const Complex& b) noexcept {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
Complex times_i(const Complex& a) noexcept { return {-a.im, a.re}; }
Complex scaled(const Complex& a, int n) noexcept { return {dvdx::scaled(a.re, n), dvdx::scaled(a.im, n)}; }

// y^(n)(0) obeys y^(n+2) = -q y^(n+1) - w y^(n) + (i theta)^n.
Forced forced_small_step(TwoDouble w, TwoDouble q, TwoDouble theta) noexcept {
  Complex y, next, power{1.0, 0.0};
  Forced sum;
  TwoDouble inverse = 1.0;  // 1/n!
  for (int n = 0; n < taylor_terms; ++n) {
    const Complex after = power - (next * q + y * w);
    y = next;
    next = after;
    power = times_i(power) * theta;
    sum.velocity = sum.velocity + y * inverse;  // y is now the derivative of order n + 1
    inverse = inverse / static_cast<double>(n + 1);
    sum.position = sum.position + y * inverse;
  }
  return sum;
}

Forced forced_doubled(const Forced& small, const PsiTable& psi, TwoDouble w, const Complex& turn) noexcept {
  const Complex held = Complex{TwoDouble(1.0) - w * psi[2], 0.0} + turn;
  const Complex kept = Complex{psi[0], 0.0} + turn;
  return {scaled(kept * small.velocity - small.position * (w * psi[1]), -1),
          scaled(held * small.position + small.velocity * psi[1], -2)};
}

// Far beyond double's phases only boundedness can be kept: the textbook's form.
Forced forced_far(double w, double q, double theta) noexcept {
  const Psi free = psi(w, q);
  const SinCos turn = sincos(theta);
  const TwoDouble re = TwoDouble(w) - two_product(theta, theta), im = two_product(q, theta);
  const TwoDouble size = re * re + im * im + psi_tiny;
  const Complex inverse{re / size, -(im / size)};
  const Complex position{turn.cos - (1.0 - w * free.psi2), turn.sin - theta * free.psi1};
  const Complex velocity{w * free.psi1 - theta * turn.sin, theta * (turn.cos - free.psi0)};
  return {velocity * inverse, position * inverse};
}

bool rings(double w, double q) noexcept { return w > farthest * farthest && 4 * w > q * q; }

TwoDouble bounded(TwoDouble w) noexcept { return w.high < psi_huge ? w : TwoDouble(psi_huge); }

}  // namespace

PsiTable flow(TwoDouble w_any, TwoDouble q, int top) noexcept {
  const TwoDouble w = bounded(w_any);
  if (rings(w.high, q.high)) return ringing(w, q, top);
  if (q.high > farthest * farthest) return creeping(w, q, top);
  const int m = halvings(std::max(std::sqrt(w.high), std::abs(q.high)));
  PsiTable psi = small_step(scaled(w, -2 * m), scaled(q, -m), top);
  for (int n = m; n > 0; --n) psi = doubled(psi, scaled(w, -2 * n), scaled(q, -n), top);
  return psi;
}

Forced forced_flow(TwoDouble w_any, TwoDouble q, TwoDouble theta) noexcept {
  const TwoDouble w = bounded(w_any);
  const double fastest = std::max({std::sqrt(w.high), std::abs(q.high), std::abs(theta.high)});
  if (!(fastest <= farthest)) {
    const double cut = 0x1p+200;  // its fourth power is finite
    return forced_far(std::min(w.high, cut), std::clamp(q.high, -cut, cut), std::clamp(theta.high, -cut, cut));
  }
  const int m = halvings(fastest);
  TwoDouble w_n = scaled(w, -2 * m), q_n = scaled(q, -m), theta_n = scaled(theta, -m);
  const PsiTable circle = small_step(theta_n * theta_n, 0.0, 3);
  Complex turn{circle[0], theta_n * circle[1]};  // exp(i theta)
  PsiTable psi = small_step(w_n, q_n, 3);
  Forced forced = forced_small_step(w_n, q_n, theta_n);
  for (int n = m; n > 0; --n) {
    forced = forced_doubled(forced, psi, w_n, turn);
    psi = doubled(psi, w_n, q_n, 3);
    turn = turn * turn;
    w_n = scaled(w_n, 2);
    q_n = scaled(q_n, 1);
  }
  return forced;
}

}  // namespace dvdx
