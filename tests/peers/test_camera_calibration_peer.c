/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* OpenCV calibrates the camera from 20 rendered boards, and finds the model that is exported. */
#define WHAT "boards"
#include "test_camera_model_peer.c"
