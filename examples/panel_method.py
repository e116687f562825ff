# SPDX-License-Identifier: Apache-2.0
"""The potential flow around a section, and derivatives of the results by the section.

Points of the plane are complex numbers x + iy, and so are gradients: ∂/∂x + i ∂/∂y.
"""

import numpy as np

PLACE = 0.4  # x of the highest camber


def naca(camber, thickness, count):
    """Returns a four-digit NACA section whose second digit is 4 (Abbott & von Doenhoff, Theory of
    Wing Sections, 6.4), with a closed trailing edge. Points are anticlockwise from the trailing
    edge, with the leading edge halfway, and denser near both."""
    x = np.cos(np.pi * np.arange(count) / count)**2
    half = 5 * thickness * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3
                            - 0.1036 * x**4)
    half[count // 2 + 1:] *= -1
    # The camber line: two parabolas that meet at its highest point.
    reach = np.where(x < PLACE, PLACE, 1 - PLACE)
    height = camber * (1 - ((x - PLACE) / reach)**2)
    along = 1 - 2j * camber * (x - PLACE) / reach**2
    return x + 1j * (height + half * along / abs(along))


def area(points):
    """Returns the area within a closed line, and its gradient by the points."""
    after, before = np.roll(points, -1), np.roll(points, 1)
    return (points.conj() * after).imag.sum() / 2, (before - after) * 0.5j


class Flow:
    """The potential flow of unit speed around a closed section, whose points are anticlockwise from
    the trailing edge. Each panel is a vortex sheet of constant strength; the stream function has the
    same value at the middles of all panels (Kennedy & Marsden, Canadian Aeronautics and Space
    Journal 22, 1976). The fluid inside is then at rest, so the strength is the speed outside.

    At p, the stream function of the panel from a to b is −strength · L Re(H) / 2π, where

        L = |b − a|,    H(a, b, p) = ∫₀¹ log(p − a − s (b − a)) ds.
    """

    def __init__(self, points, incidence):
        a, b = points, np.roll(points, -1)
        panel = b - a
        self.length, self.tangent = abs(panel), panel / abs(panel)
        self.onflow = np.exp(1j * incidence)
        self.middle = (a + b) / 2
        p = self.middle[:, None]  # points are rows, panels are columns
        angle, end = np.log((p - a) / (p - b)), np.log(p - b)
        integral = (p - a) / panel * angle + end - 1
        self.integral = integral.real
        # H is analytic and depends on differences of a, b and p only: its derivatives sum to 0,
        # which gives ∂H/∂p.
        self.by_a, self.by_b = (integral - angle - end) / panel, (end - integral) / panel
        # The unknowns are the strengths and the value of the stream function. The last row is
        # the Kutta condition: the flow leaves both sides of the trailing edge at the same speed.
        count = len(points)
        self.matrix = np.zeros((count + 1, count + 1))
        self.matrix[:-1, :-1] = -self.length * self.integral / (2 * np.pi)
        self.matrix[:-1, -1] = -1
        self.matrix[-1, [0, -2]] = 1
        stream = (self.middle * self.onflow.conjugate()).imag
        self.strength = np.linalg.solve(self.matrix, -np.append(stream, 0))[:-1]

    @property
    def pressure(self):
        """The pressure coefficient of each panel."""
        return 1 - self.strength**2

    @property
    def lift(self):
        """The lift coefficient for a chord of 1, by the Kutta-Joukowski theorem."""
        return -2 * self.strength @ self.length

    def gradient(self, by_strength):
        """Returns the gradient by the points of a function of the strengths, given its gradient by
        the strengths: one solve with the transposed matrix, whatever the number of points."""
        adjoint = np.linalg.solve(self.matrix.T, np.append(by_strength, 0))[:-1]
        weight = np.outer(adjoint, self.strength) / (2 * np.pi)  # weight of L Re(H)
        stretch = self.tangent * (weight * self.integral).sum(axis=0)
        weight *= self.length
        by_a = (weight * self.by_a.conj()).sum(axis=0) - stretch
        by_b = (weight * self.by_b.conj()).sum(axis=0) + stretch
        by_middle = -(weight * (self.by_a + self.by_b).conj()).sum(axis=1)
        by_middle -= adjoint * 1j * self.onflow
        return by_a + by_middle / 2 + np.roll(by_b + by_middle / 2, 1)
