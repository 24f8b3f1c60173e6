/* SPDX-License-Identifier: Apache-2.0 */
/* Says that a program is of the tile schedule. What only that schedule has includes it first. */
#ifndef MCVISI_KERNELS_TILE_H
#define MCVISI_KERNELS_TILE_H

#define MCV_TILE 1
#define MCV_ROWS_SPACE __private /* traverse/rows.h */

#endif
