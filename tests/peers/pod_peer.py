# SPDX-License-Identifier: Apache-2.0
"""pod_peer.py DATA: what SciPy and statsmodels make of an experiment, one number a line.

DATA holds doubles: kind (0: signals, 1: censored ones, 2: hits and misses), threshold, low, high,
then x and y of each defect, in turn.
"""

import math
import sys

import numpy
import statsmodels.api as sm
from scipy import optimize, stats
from statsmodels.stats.diagnostic import het_breuschpagan, normal_ad


def response(x, y, threshold):
    design = sm.add_constant(x)
    fit = sm.OLS(y, design).fit()
    parabola = sm.OLS(y, numpy.column_stack([design, x * x])).fit()
    s = math.sqrt(fit.scale)

    def margin(at):
        row = numpy.array([1, at])
        h = math.sqrt(row @ fit.normalized_cov_params @ row)
        factor = h * stats.nct.ppf(0.95, len(x) - 2, stats.norm.ppf(0.9) / h)
        return row @ fit.params - factor * s - threshold

    yield from fit.params
    yield s
    yield fit.llf
    yield optimize.brentq(margin, x.min(), x.max(), xtol=1e-13)
    yield parabola.pvalues[2]
    yield het_breuschpagan(fit.resid, design)[1]
    yield normal_ad(fit.resid)[1]


def censored(x, y, low, high):
    lost, saturated = y <= low, y >= high
    inside = ~(lost | saturated)

    def minus(p):
        mean, s = p[0] + p[1] * x, math.exp(p[2])
        return -(
            stats.norm.logpdf(y, mean, s)[inside].sum()
            + stats.norm.logcdf(low, mean, s)[lost].sum()
            + stats.norm.logsf(high, mean, s)[saturated].sum()
        )

    start = [*sm.OLS(y, sm.add_constant(x)).fit().params, 0.0]
    for _ in range(3):
        found = optimize.minimize(minus, start, method="BFGS", options={"gtol": 1e-9})
        start = found.x
    yield from found.x[:2]
    yield math.exp(found.x[2]) * math.sqrt(len(x) / (len(x) - 2))
    yield -found.fun


def hit_miss(x, y):
    fit = sm.Logit(y, sm.add_constant(x)).fit(disp=0, tol=1e-14, maxiter=100)
    logit = math.log(9)

    def root(at):
        held = sm.GLM(y, (x - at)[:, None], sm.families.Binomial(), offset=numpy.full(len(x), logit))
        return 2 * (fit.llf - held.fit(tol=1e-14).llf) - stats.norm.ppf(0.95) ** 2

    a90 = (logit - fit.params[0]) / fit.params[1]
    yield from fit.params
    yield fit.llf
    yield optimize.brentq(root, a90 + 1e-9, x.max(), xtol=1e-13)


def main(path):
    data = numpy.fromfile(path)
    kind, threshold, low, high = data[:4]
    x, y = data[4::2], data[5::2]
    numbers = (
        response(x, y, threshold)
        if kind == 0
        else censored(x, y, low, high)
        if kind == 1
        else hit_miss(x, y)
    )
    for number in numbers:
        print(repr(float(number)))


main(sys.argv[1])
