// Boost.odeint beside afterbay: Fehlberg 7(8), Bulirsch-Stoer and Dormand-Prince 5(4), and
// Rosenbrock 4 for scenes of few unknowns.
//
// Each line of stdin asks for a run: SCENE METHOD TOLERANCE REPEATS SHOW. The answer is, if SHOW is
// 1, a line `state Y..` after each accepted step, then `done SECONDS STEPS EVALUATIONS Y..` with
// the least time of the repetitions, or `failed REASON`. Y is q, then p, then w.
#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace odeint = boost::numeric::odeint;
namespace ublas = boost::numeric::ublas;

static long evaluations;

// q' = p, p' = -k q - beta q^3 - D, with D = c p
template <int k, int beta> struct Duffing {
    static constexpr double c = 0.1;
    template <class Y> void operator()(const Y &y, Y &dy, double) const {
        ++evaluations;
        const double q = y[0], p = y[1], d = c * p;
        dy[0] = p;
        dy[1] = -q * (k + beta * q * q) - d;
        dy[2] = d * p;
    }
    template <class Y> void jacobian(const Y &y, ublas::matrix<double> &j) const {
        const double q = y[0], p = y[1];
        j(1, 0) = -k - 3 * beta * q * q;
        j(1, 1) = -c;
        j(2, 1) = 2 * c * p;
    }
};

// The same with V = q^2/2 and D = mu (q^2 - 1) p
template <int mu> struct VanDerPol {
    template <class Y> void operator()(const Y &y, Y &dy, double) const {
        ++evaluations;
        const double q = y[0], p = y[1], d = mu * (q * q - 1) * p;
        dy[0] = p;
        dy[1] = -q - d;
        dy[2] = d * p;
    }
    template <class Y> void jacobian(const Y &y, ublas::matrix<double> &j) const {
        const double q = y[0], p = y[1], rate = mu * (q * q - 1), bend = 2 * mu * q * p;
        j(1, 0) = -1 - bend;
        j(1, 1) = -rate;
        j(2, 0) = bend * p;
        j(2, 1) = 2 * rate * p;
    }
};

// FPUT-beta chain between walls: tension r + r^3, friction 0.01 p
struct Chain {
    std::size_t n;
    void operator()(const std::vector<double> &y, std::vector<double> &dy, double) const {
        ++evaluations;
        const double *q = y.data(), *p = q + n;
        double *dq = dy.data(), *dp = dq + n, *dw = dp + n;
        const double c = 0.01;
        const auto tension = [](double r) { return r * (1 + r * r); };
        for (std::size_t j = 0; j < n; ++j) {
            dq[j] = p[j];
            dw[j] = c * p[j] * p[j];
        }
        dp[0] = tension(q[1] - q[0]) - tension(q[0]) - c * p[0];
        for (std::size_t j = 1; j + 1 < n; ++j)
            dp[j] = tension(q[j + 1] - q[j]) - tension(q[j] - q[j - 1]) - c * p[j];
        dp[n - 1] = tension(-q[n - 1]) - tension(q[n - 1] - q[n - 2]) - c * p[n - 1];
    }
};

// Two unit rods with unit masses, g = 1 and friction 0.1 in both joints
struct Pendulum {
    template <class Y> void operator()(const Y &y, Y &dy, double) const {
        ++evaluations;
        const double sin = std::sin(y[0] - y[1]), cos = std::cos(y[0] - y[1]);
        const double inverse = 1 / (1 + sin * sin);
        const double u = (y[2] - cos * y[3]) * inverse, v = (2 * y[3] - cos * y[2]) * inverse;
        const double whirl = sin * u * v;
        dy[0] = u;
        dy[1] = v;
        dy[2] = -whirl - 2 * std::sin(y[0]) - 0.1 * u;
        dy[3] = whirl - std::sin(y[1]) - 0.1 * v;
        dy[4] = 0.1 * u * u;
        dy[5] = 0.1 * v * v;
    }
};

struct Request {
    std::string scene, method;
    double tolerance;
    int repeats;
    bool show;
};

template <class Y> void print(const Y &y) {
    for (const double x : y) std::printf(" %.17g", x);
    std::printf("\n");
}

// Runs `repeats` times from `start`, and prints the answer. `make` creates the stepper.
template <class Y, class F, class Make>
void run(const Request &request, const F &field, const Y &start, double end, Make make) {
    // The first step that the library is offered, as in its examples.
    const double first = 1e-3;
    double least = std::numeric_limits<double>::infinity();
    std::size_t steps = 0;
    Y y = start;
    for (int repeat = 0; repeat < request.repeats; ++repeat) {
        y = start;
        evaluations = 0;
        auto stepper = make(request.tolerance);
        const auto clock = std::chrono::steady_clock::now();
        steps = odeint::integrate_adaptive(stepper, field, y, 0.0, end, first);
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - clock;
        least = std::min(least, elapsed.count());
    }
    const long counted = evaluations;
    if (request.show) {
        Y shown = start;
        auto stepper = make(request.tolerance);
        odeint::integrate_adaptive(stepper, field, shown, 0.0, end, first, [](const Y &y, double) {
            std::printf("state");
            print(y);
        });
    }
    std::printf("done %.17g %zu %ld", least, steps, counted);
    print(y);
}

template <class Y, class F>
bool run_explicit(const Request &request, const F &field, const Y &start, double end) {
    if (request.method == "rkf78")
        run(request, field, start, end, [](double tolerance) {
            return odeint::make_controlled(tolerance, tolerance, odeint::runge_kutta_fehlberg78<Y>());
        });
    else if (request.method == "dopri5")
        run(request, field, start, end, [](double tolerance) {
            return odeint::make_controlled(tolerance, tolerance, odeint::runge_kutta_dopri5<Y>());
        });
    else if (request.method == "bulirsch-stoer")
        run(request, field, start, end, [](double tolerance) {
            return odeint::bulirsch_stoer<Y>(tolerance, tolerance);
        });
    else
        return false;
    return true;
}

// Rosenbrock 4 takes the Jacobian, and vectors of its own.
template <class F>
bool run_rosenbrock(const Request &request, const F &field, const std::array<double, 3> &start,
                    double end) {
    typedef ublas::vector<double> Y;
    Y y(3);
    std::copy(start.begin(), start.end(), y.begin());
    const auto jacobian = [&field](const Y &y, ublas::matrix<double> &j, const double &, Y &dt) {
        j.clear();
        j(0, 1) = 1;
        field.jacobian(y, j);
        dt.clear();
    };
    run(request, std::make_pair(field, jacobian), y, end, [](double tolerance) {
        return odeint::make_controlled(tolerance, tolerance, odeint::rosenbrock4<double>());
    });
    return true;
}

template <class F>
bool run_one(const Request &request, const F &field, std::array<double, 3> start, double end) {
    if (request.method == "rosenbrock4") return run_rosenbrock(request, field, start, end);
    return run_explicit(request, field, start, end);
}

static bool answer(const Request &request) {
    if (request.scene == "A") return run_one(request, Duffing<1, 0>{}, {2.3, -3.1, 0}, 100);
    if (request.scene == "B") return run_one(request, Duffing<-1, 1>{}, {1.5, 0.5, 0}, 50);
    if (request.scene == "C1") return run_one(request, VanDerPol<1>{}, {2, 0, 0}, 50);
    if (request.scene == "C2") return run_one(request, VanDerPol<1000>{}, {2, 0, 0}, 2000);
    if (request.scene == "E")
        return run_explicit(request, Pendulum{}, std::array<double, 6>{1.5, -0.5}, 5);
    if (request.scene != "D64" && request.scene != "D1024") return false;
    const std::size_t n = request.scene == "D64" ? 64 : 1024;
    std::vector<double> start(3 * n);
    for (std::size_t j = 0; j < n; ++j) start[j] = std::sin(M_PI * (j + 1.0) / (n + 1.0));
    return run_explicit(request, Chain{n}, start, 100);
}

int main() {
    std::string line;
    while (std::getline(std::cin, line)) {
        Request request;
        std::istringstream words(line);
        if (!(words >> request.scene >> request.method >> request.tolerance >> request.repeats >>
              request.show))
            std::printf("failed the request is not understood\n");
        else
            try {
                if (!answer(request)) std::printf("failed no such scene or method\n");
            } catch (const std::exception &error) {
                std::string why = error.what();
                std::replace(why.begin(), why.end(), '\n', ' ');
                std::printf("failed %s\n", why.c_str());
            }
        std::fflush(stdout);
    }
}
