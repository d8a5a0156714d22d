// SPDX-License-Identifier: MIT
// Light constants of all backends: linear radiance, 1 is white. A white diffuse surface that faces
// between the key light and the eye gets 0.8 to 0.95, so base colours are nearly preserved and not
// overexposed.
#ifndef LIGHT_CONSTANTS_H
#define LIGHT_CONSTANTS_H

// Diffuse: from above, from below, from the key light, from the eye.
#define LIGHT_SKY_R 0.270f
#define LIGHT_SKY_G 0.285f
#define LIGHT_SKY_B 0.310f
#define LIGHT_GROUND_R 0.105f
#define LIGHT_GROUND_G 0.101f
#define LIGHT_GROUND_B 0.097f
#define LIGHT_KEY_R 0.60f
#define LIGHT_KEY_G 0.59f
#define LIGHT_KEY_B 0.57f
#define LIGHT_FILL 0.16f // factor on the squared cosine: surfaces darken towards their edges

// Where the normals of what a splat stands for are spread: of a whole sphere, of which the eye sees
// a half, means by visible area of the normals towards the eye, and of their squared cosines.
#define SPREAD_TO_EYE 0.6667f
#define SPREAD_FILL 0.5f
#define SPREAD_LAMBERT 0.2f // how softly light from the key ends, as a share of the variance
#define SPREAD_GLOSS 0.5f   // by how much the variance widens the key light's highlight

// Reflected environment: sky, from the horizon to the zenith, ground, and two soft boxes beside the
// eye.
#define MIRROR_HORIZON_R 0.74f
#define MIRROR_HORIZON_G 0.77f
#define MIRROR_HORIZON_B 0.82f
#define MIRROR_GROUND_R 0.11f
#define MIRROR_GROUND_G 0.105f
#define MIRROR_GROUND_B 0.10f
#define MIRROR_ZENITH 0.55f // factor on the horizon's light
#define MIRROR_BOX_LEFT 0.85f
#define MIRROR_BOX_RIGHT 0.45f
#define MIRROR_LEFT_EDGE 0.80f // cosine of the angle from the centre of a box to its edge
#define MIRROR_RIGHT_EDGE 0.88f
#define MIRROR_BLUR 0.10f      // width of edges, in cosines, on polished surfaces
#define MIRROR_BLUR_ROUGH 1.5f // additional width on rough surfaces
// share of a box's light that blur spreads outside it, on rough surfaces
#define MIRROR_ROUGH_BOX 0.7f

#define LIGHT_DIELECTRIC 0.04f // reflectance at normal incidence
#define LIGHT_GRAZING 0.5f     // additional reflectance at grazing angles on polished surfaces
#define LIGHT_GLOSS_MAX 3.0f   // upper bound of the key light's highlight

// Directions of soft boxes: right, up and back of the view.
#define MIRROR_LEFT_BOX -0.62f, 0.55f, 0.56f
#define MIRROR_RIGHT_BOX 0.86f, 0.12f, 0.30f

#endif
