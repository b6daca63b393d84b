"""Estimators of scikit-learn: sparse regression, and a model of recordings."""

from __future__ import annotations

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.metrics import r2_score
from sklearn.utils.validation import check_is_fitted, validate_data

from . import Model, fit, stlsq


class STLSQ(RegressorMixin, BaseEstimator):
    """Sequentially thresholded least squares (Brunton, Proctor, Kutz 2016): y ≈ X coef_ with few coefficients.

    threshold: share of a target's variance below which a term is dropped (pysindy's is a bound on the coefficient, which
    depends on units). ridge: penalty on the coefficients of columns scaled by their RMS. rounds: most rounds of dropping.

    `coef_` is (features,) for a target of one dimension, else (targets, features).
    """

    def __init__(self, threshold: float = 1e-6, ridge: float = 0.0, rounds: int = 20):
        self.threshold = threshold
        self.ridge = ridge
        self.rounds = rounds

    def fit(self, X, y):
        """Fits to X (rows, features) and y (rows,) or (rows, targets)."""
        X, y = validate_data(self, X, y, dtype=np.float64, multi_output=True, y_numeric=True)
        targets = np.asarray(y, dtype=np.float64).reshape(len(y), -1)
        coefficients = stlsq(X, targets, threshold=self.threshold, ridge=self.ridge, rounds=self.rounds)
        self.coef_ = coefficients[:, 0] if y.ndim == 1 else coefficients.T
        return self

    def predict(self, X):
        """Predictions for X (rows, features)."""
        check_is_fitted(self)
        return validate_data(self, X, dtype=np.float64, reset=False) @ self.coef_.T

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        # There is no intercept: a constant is a feature like any other.
        tags.regressor_tags.poor_score = True
        return tags


class SindyNN(BaseEstimator):
    """Autoencoder with sparse dynamics of virtual states, of vibration recordings of a healthy machine.

    X is (recordings, samples) in m/s² at sample_rate_hz. `predict` gives the predicted derivatives (recordings, rows,
    derivatives) in the model's scaled units, `score` their R² over all recordings. The other parameters are those of
    `ballrace.fit`.
    """

    def __init__(self, sample_rate_hz: float = 25600.0, dimension: int = 8, degree: int = 2, harmonics: int = 2,
                 max_steps: int | None = None, seed: int = 0):
        self.sample_rate_hz = sample_rate_hz
        self.dimension = dimension
        self.degree = degree
        self.harmonics = harmonics
        self.max_steps = max_steps
        self.seed = seed

    def fit(self, X, y=None):
        """Fits to recordings X (recordings, samples)."""
        from . import Recording

        X = validate_data(self, X, dtype=np.float64)
        rows = [Recording({"a": np.ascontiguousarray(row)}, self.sample_rate_hz, name=f"r{n}") for n, row in enumerate(X)]
        self.model_: Model = fit(rows, dimension=self.dimension, degree=self.degree, harmonics=self.harmonics,
                                 max_steps=self.max_steps, trainings=1, null=0, seed=self.seed)
        return self

    def _traces(self, X):
        check_is_fitted(self)
        X = validate_data(self, X, dtype=np.float64, reset=False)
        return [self.model_.predict(np.ascontiguousarray(row)) for row in X]

    def predict(self, X):
        """Predicted derivatives (recordings, rows, derivatives)."""
        return np.stack([trace["predicted"] for trace in self._traces(X)])

    def score(self, X, y=None) -> float:
        """R² of the predicted derivatives, the mean over derivatives."""
        traces = self._traces(X)
        measured = np.concatenate([trace["measured"] for trace in traces])
        return float(r2_score(measured, np.concatenate([trace["predicted"] for trace in traces])))
