"""Update the estimator with each sample."""


def estimate_parameters(step):
    """Return the parameters, or None where there is no sample."""
    if step.sample is None:
        return None
    return step.estimator.update(step.sample.phi, step.sample.y)
