"""Variants of tests that repeat at length what a quicker variant beside them tests: they run with --slow only.

Each of them compiles kernels of its own for 10 to 150 s; the suite of every change stays short without them.
"""

SLOW_VARIANTS = {
    "test_bench": {
        "test_every_element_is_measured_against_its_own_reference_and_plain_kernel[tet4-ogden-6]",
    },
    "test_bodies_together": {
        "test_with_friction_and_on_the_path_of_large_bodies_too",
    },
    "test_cell_blocks": {
        "test_every_term_keeps_momentum_and_energy[friction on masses]",
        "test_every_term_keeps_momentum_and_energy[layers]",
        "test_every_term_keeps_momentum_and_energy[viscosity and damping]",
        "test_impact_on_contact_cells_of_two_kinds_and_materials_keeps_the_ledger[beside-falling-4-normal]",
    },
    "test_central_difference": {
        "test_every_row_equals_the_oracle[tet4-linear-1-normal-None-supports6]",
    },
    "test_friction": {
        "test_a_belt_takes_a_block_to_its_speed[full]",
    },
    "test_friction_contact_layer": {
        "test_a_mass_brought_to_rest_has_turned_into_friction_work_and_heat[full]",
    },
    "test_friction_fields": {
        "test_the_work_of_all_nodes_is_that_of_the_ledger[pair and floor, normal]",
    },
    "test_friction_laws": {
        "test_pairs_and_obstacles_have_their_own_laws[full]",
        "test_every_obstacle_at_a_node_has_its_own_friction[full]",
        "test_a_sliding_block_slows_down_by_its_law[constant-full]",
        "test_a_sliding_block_slows_down_by_its_law[falling-full]",
    },
    "test_implicit_blocks": {
        "test_an_impact_is_that_of_the_explicit_scheme[full]",
    },
    "test_initial_layers": {
        "test_the_start_of_another_scene_may_differ_and_new_nodes_begin_cold",
    },
    "test_layers_heat_bodies": {
        "test_points_whose_heat_has_a_pressure_keep_the_heat_of_the_layers",
        "test_the_far_end_has_the_temperature_of_the_cells",
    },
    "test_layers_two_sides": {
        "test_equal_blocks_share_the_heat_equally[full-contact1]",
    },
    "test_load_cases": {
        "test_the_checks_of_the_cases_hold[tcontact.cases.inflated_ring-12]",
    },
    "test_maxima": {
        "test_every_frame_has_the_same_maxima[serial]",
        "test_every_frame_has_the_same_maxima[two bodies, two materials]",
        "test_every_frame_has_the_same_maxima[node-averaged]",
        "test_every_frame_has_the_same_maxima[mean dilatation]",
    },
    "test_mean_dilatation_runs": {
        "test_cube_impact_meets_its_checks[{'poisson': 0.499, 'law': 'mooney-rivlin'}]",
        "test_cube_impact_meets_its_checks[{'poisson': 0.45, 'pitch': 10.0, 'yaw': 20.0}]",
    },
    "test_mixed_precision": {
        "test_every_element_has_the_force_of_float64_in_bodies_of_every_size[hex8-0.0]",
        "test_every_element_has_the_force_of_float64_in_bodies_of_every_size[hex8-reduced-0.0]",
        "test_every_element_has_the_force_of_float64_in_bodies_of_every_size[hex8-mean-dilatation-0.0]",
    },
    "test_mixed_runs": {
        "test_a_drop_has_the_force_and_impulse_of_float64[contact0-parallel]",
        "test_a_drop_has_the_force_and_impulse_of_float64[contact1-one launch]",
    },
    "test_momentum": {
        "test_free_fall_strains_nothing[full-linear-tet4]",
        "test_free_fall_strains_nothing[normal-neo-tet4]",
        "test_free_fall_strains_nothing[normal-linear-hex8]",
        "test_free_fall_strains_nothing[full-svk-hex8]",
    },
    "test_mooney_rivlin": {
        "test_same_equilibrium_as_the_oracle[hex8-full]",
    },
    "test_moving_wall": {
        "test_only_the_relative_velocity_counts[full]",
        "test_only_the_relative_velocity_counts[penalty-coulomb]",
        "test_only_the_relative_velocity_counts[impulse-coulomb]",
    },
    "test_pair_files": {
        "test_a_resumed_run_has_the_same_bits[parallel]",
    },
    "test_pair_friction": {
        "test_a_block_slides_to_rest_on_a_free_block[parameters1]",
        "test_a_block_holds_on_a_held_incline_without_creep[full]",
    },
    "test_pair_obstacles": {
        "test_a_turned_corner_is_the_same_corner",
    },
    "test_pair_runs": {
        "test_oblique_cubes_keep_energy_and_momentum[tet4]",
        "test_oblique_cubes_keep_energy_and_momentum[wedge6]",
        "test_formulations_of_hexahedra[mean-dilatation]",
    },
    "test_pair_statics": {
        "test_three_bodies_above_a_plane_are_solved_as_by_a_dense_active_set[shoulder-hex8]",
    },
    "test_periodic": {
        "test_one_period_is_what_many_periods_are[one-point hexes, gravity]",
        "test_one_period_is_what_many_periods_are[full removal, tets, damping]",
        "test_one_period_is_what_many_periods_are[prisms, full removal]",
        "test_one_period_is_what_many_periods_are[full removal, own force, gravity in time]",
        "test_one_period_is_what_many_periods_are[penalty, supports, viscosity]",
    },
    "test_plate_impact": {
        "test_copper_meets_its_shock_curve[200.0]",
    },
    "test_reduced": {
        "test_force_and_energy_match_numpy_and_each_other[neo]",
    },
    "test_reduced_runs": {
        "test_one_and_two_threads_give_the_same_bits",
        "test_cube_impact_with_one_point_hexes[full]",
        "test_balance_in_mid_contact[neo-full-2]",
    },
    "test_set_up": {
        "test_nearest_points_are_those_of_all_triangles[300-1e-06]",
        "test_nearest_points_are_those_of_all_triangles[300-1000000.0]",
    },
    "test_shape_bound": {
        "test_rates_are_those_of_the_worst_cells[wedge6-None]",
    },
    "test_stability": {
        "test_hard_case[jittered-tets]",
        "test_hard_case[tets-all-in-contact-set]",
    },
    "test_static_solve": {
        "test_same_equilibrium_as_the_oracle[hex8-linear-full-3-None]",
        "test_same_equilibrium_as_the_oracle[tet4-svk-full-1-40.0]",
    },
    "test_viscosity": {
        "test_momentum_in_an_impact[tet4-normal-1]",
    },
    "test_walls": {
        "test_a_wall_out_of_reach_changes_not_a_bit[normal removal, parallel]",
        "test_a_floor_named_several_times_rubs_as_one[3]",
    },
}
