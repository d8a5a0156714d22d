// SPDX-License-Identifier: MIT
#include "lab/scenes/gltf_plan.h"

// The unit quaternion of a rotation: from its largest component, whose square the diagonal gives.
static void find_quaternion(double m[3][3], double q[4])
{
    double trace = m[0][0] + m[1][1] + m[2][2];
    if (trace > 0.0) {
        double s = 2.0 * sqrt(trace + 1.0);
        q[3] = 0.25 * s;
        q[0] = (m[2][1] - m[1][2]) / s;
        q[1] = (m[0][2] - m[2][0]) / s;
        q[2] = (m[1][0] - m[0][1]) / s;
        return;
    }
    int i = m[1][1] > m[0][0] ? 1 : 0;
    i = m[2][2] > m[i][i] ? 2 : i;
    int j = (i + 1) % 3, k = (i + 2) % 3;
    double s = 2.0 * sqrt(1.0 + m[i][i] - m[j][j] - m[k][k]);
    q[i] = 0.25 * s;
    q[j] = (m[j][i] + m[i][j]) / s;
    q[k] = (m[k][i] + m[i][k]) / s;
    q[3] = (m[k][j] - m[j][k]) / s;
}

bool gltf_decompose(const stp_affine* affine, float translation[3], float rotation[4],
                    float scale[3])
{
    double m[3][3], lengths[3], q[4];
    for (int c = 0; c < 3; ++c) {
        double square = 0.0;
        for (int r = 0; r < 3; ++r) {
            square += affine->m[r][c] * affine->m[r][c];
        }
        lengths[c] = sqrt(square);
        if (!(lengths[c] > 0.0)) {
            return false;
        }
    }
    lengths[0] *= stp_affine_determinant(affine) < 0.0 ? -1.0 : 1.0;
    for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) {
            m[r][c] = affine->m[r][c] / lengths[c];
        }
    }
    for (int c = 0; c < 3; ++c) { // skewed axes are not a rotation
        int next = (c + 1) % 3;
        double dot = m[0][c] * m[0][next] + m[1][c] * m[1][next] + m[2][c] * m[2][next];
        if (dot > 1e-6 || dot < -1e-6) {
            return false;
        }
    }
    find_quaternion(m, q);
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; ++i) {
        rotation[i] = (float)(q[i] / length);
    }
    for (int i = 0; i < 3; ++i) {
        translation[i] = (float)affine->m[i][3];
        scale[i] = (float)lengths[i];
    }
    return true;
}
