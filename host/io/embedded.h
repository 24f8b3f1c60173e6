/* SPDX-License-Identifier: Apache-2.0 */
/* Styles and scripts of pages, which CMake makes of the files beside their pages (mcv_embed in
 * CMakeLists.txt). The hashes are as a content security policy has them: "sha256-…". */
#ifndef MCVISI_HOST_IO_EMBEDDED_H
#define MCVISI_HOST_IO_EMBEDDED_H

extern const char mcv_setup_css[], mcv_setup_css_hash[]; /* check/setup.css */
extern const char mcv_sweep_css[], mcv_sweep_css_hash[]; /* experiment/sweep.css */
extern const char mcv_sweep_js[], mcv_sweep_js_hash[];   /* experiment/sweep.js */

#endif
