/* SPDX-License-Identifier: Apache-2.0 */
/* What the loader of OpenCL asks of a layer (CL/cl_layer.h); a layer says what it puts between. */
#ifndef MCVISI_TESTS_CL_LAYER_H
#define MCVISI_TESTS_CL_LAYER_H

#include <CL/cl.h>
#include <CL/cl_layer.h>

#include <string.h>

/* The functions of the layer, which stand before those of the target. */
const struct _cl_icd_dispatch *layer_begin(const struct _cl_icd_dispatch *target);

cl_int CL_API_CALL clGetLayerInfo(cl_layer_info param_name, size_t param_value_size,
                                  void *param_value, size_t *param_value_size_ret) {
    const cl_layer_api_version version = CL_LAYER_API_VERSION_100;
    if (param_name != CL_LAYER_API_VERSION || (param_value && param_value_size < sizeof version))
        return CL_INVALID_VALUE;
    if (param_value) memcpy(param_value, &version, sizeof version);
    if (param_value_size_ret) *param_value_size_ret = sizeof version;
    return CL_SUCCESS;
}

cl_int CL_API_CALL clInitLayer(cl_uint num_entries, const struct _cl_icd_dispatch *target_dispatch,
                               cl_uint *num_entries_ret,
                               const struct _cl_icd_dispatch **layer_dispatch_ret) {
    const cl_uint needed = sizeof *target_dispatch / sizeof(void *);
    if (!target_dispatch || !num_entries_ret || !layer_dispatch_ret || num_entries < needed)
        return CL_INVALID_VALUE;
    *num_entries_ret = needed;
    *layer_dispatch_ret = layer_begin(target_dispatch);
    return CL_SUCCESS;
}

#endif
